"""Writes `gearwise/_words.py` and `gearwise/_design.py` from what the reader of requirements asks for and from the schema
of the JSON, so that no key is written down twice. `--check` says whether they are up to date.

Needs the native module: `pip install .` first."""

import importlib.util
import json
import pathlib
import sys
import sysconfig
import textwrap

HERE = pathlib.Path(__file__).parent


def the_native():
    """The native module, from beside this file or from where it is installed, without the package, which may not be whole."""
    for folder in (HERE / "gearwise", pathlib.Path(sysconfig.get_path("platlib")) / "gearwise"):
        for path in folder.glob("_native*"):
            if path.suffix in (".so", ".pyd"):
                spec = importlib.util.spec_from_file_location("_native", path)
                module = importlib.util.module_from_spec(spec)
                spec.loader.exec_module(module)
                return module
    sys.exit("the native module is not there: pip install . first")


native = the_native()
HEAD = '# Written by python/generate.py: change the reader or the schema, not this file.\n'
LIGHT = '''
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from os import PathLike
    from typing import Any

    from gearwise._native import Motion
'''
# Class, table of the file, its text, keys that come first and may be given by their place.
CLASSES = [
    ("Bus", "[bus]", "The supply.", ["voltage"]),
    ("Gear", "[gear]", "The gear that goes with a continuous ratio.", ["efficiency"]),
    ("Limits", "[limits]", "What a choice must keep.", []),
    ("Joint", "[[joint]]", "What a joint has to do, and what may be chosen for it.", ["name", "motion"]),
    ("Robot", "", "A robot: its supply and its joints.", ["name", "bus", "joints"]),
]
# What Python takes beyond what the file has.
TYPES = {
    ("Joint", "motion"): "Motion | str | PathLike[str] | None",
    ("Joint", "ratio"): "tuple[float, float] | Mapping[str, object] | None",
    ("Joint", "gear"): "Gear | Mapping[str, object] | None",
    ("Joint", "limits"): "Limits | Mapping[str, object] | None",
    ("Robot", "bus"): "Bus | Mapping[str, object] | None",
    ("Robot", "joints"): "Sequence[Joint | Mapping[str, object]]",
    ("Robot", "ambient"): "float | str | Mapping[str, object] | None",
}
# Names of Python for keys of the file.
NAMES = {("Robot", "joint"): "joints"}
# Keys that must be there.
REQUIRED = {"Bus": ["voltage"], "Joint": ["name"], "Robot": ["name", "bus", "joints"]}
# Keys that are no longer, or not yet, read.
REFUSED = "refused by this version"


def kind(value: str) -> str:
    """The type of Python for what may stand at a key."""
    if value.startswith(("number", "weight")):
        return "float | None"
    if value.startswith("whole number"):
        return "int | None"
    if value.startswith("`true`"):
        return "bool | None"
    if value.startswith("list of tables"):
        return "Sequence[Mapping[str, object]] | None"
    if value.startswith("list of lists"):
        return "Sequence[Sequence[float]] | None"
    if value.startswith("list of numbers"):
        return "Sequence[float] | Mapping[str, float] | None"
    if value.startswith("list"):
        return "Sequence[str] | None"
    if value.startswith(("table", "name of a quantity")):
        return "str | Mapping[str, object] | None" if value.startswith("name") else "Mapping[str, object] | None"
    if value.startswith("["):
        return "Sequence[object] | None"
    if value.startswith("file"):
        return "str | PathLike[str] | None"
    if ", as `" in value:
        return "float | str | None"
    if value.startswith("`"):
        return "str | None"
    return "object | None" if "table" in value else "str | None"


def wrapped(text: str, indent: str) -> str:
    """A docstring at an indent."""
    text = text.replace("\\[", "[").replace("\\]", "]").replace("\\", "\\\\").strip()
    if len(text) + len(indent) + 6 <= 120:
        return f'{indent}"""{text}"""\n'
    lines = textwrap.wrap(text, 120 - len(indent), break_long_words=False)
    return f'{indent}"""' + f"\n{indent}".join(lines) + f'\n{indent}"""\n'


def words() -> str:
    """The text of `_words.py`."""
    tables: dict[str, list[tuple[str, str, str]]] = {}
    for table, name, value, meaning, _ in native.describe():
        if meaning != REFUSED and value != "–":
            tables.setdefault(table, []).append((name, value, meaning))
    out = '"""What is asked, in the words of a requirement file: the reader of files checks it."""\n\n' + HEAD + LIGHT
    out += "\nfrom gearwise._light import final\nfrom gearwise._table import Words\n"
    for name, table, about, first in CLASSES:
        keys = [(NAMES.get((name, key), key), key, value, meaning) for key, value, meaning in tables[table]]
        keys.sort(key=lambda k: first.index(k[0]) if k[0] in first else len(first))
        said = about + " A number is SI, a text has its unit (\"48 V\"); what is left out holds as in a file."
        required = REQUIRED.get(name, [])
        out += f"\n\n@final\nclass {name}(Words):\n" + wrapped(said, "    ") + "\n"
        out += f"    __slots__ = ({', '.join(repr(key) for key, *_ in keys)},)\n"
        out += "    _keys = {" + ", ".join(f'"{py}": "{key}"' for py, key, *_ in keys if py != key) + "}\n\n"
        types = {py: TYPES.get((name, py), kind(value)) for py, _, value, _ in keys}
        for py, _, value, meaning in keys:
            bare = types[py].removesuffix(" | None") if py in required else types[py]
            out += f'    {py}: "{bare}"\n'
            unit = value.split(", as ")[0].replace("`", "") if ", as " in value else ""
            out += wrapped((meaning[:1].upper() + meaning[1:] or "As in the file") + (f" [{unit}]." if unit else "."), "    ")
        out += "\n    def __init__(\n        self,\n"
        starred = False
        for py, *_ in keys:
            if py not in first and not starred:
                out += "        *,\n"
                starred = True
            bare = types[py].removesuffix(" | None") if py in required else types[py]
            out += f'        {py}: "{bare}"' + (",\n" if py in required else " = None,\n")
        out += '    ) -> None:\n        """Words of a requirement; what is left out holds as in a file."""\n'
        out += "        self._fill(" + ", ".join(f"{py}={py}" for py, *_ in keys) + ")\n"
    return out


def typed(schema: dict, optional: bool) -> str:
    """The type of Python of a key of the JSON."""
    of = schema.get("type")
    names = {"string": "str", "number": "float", "integer": "int", "boolean": "bool"}
    if isinstance(of, list):
        inner = [names.get(t, "Any") for t in of if t != "null"]
        return " | ".join([*inner, "None"])
    if of == "array":
        item = schema.get("items", {})
        inner = names.get(item.get("type"), "Mapping[str, Any]") if isinstance(item.get("type"), str) else "Mapping[str, Any]"
        found = f"Sequence[{inner}]"
        if schema.get("maxItems") == 2 == schema.get("minItems"):
            found = f"tuple[{inner}, {inner}]"
    elif of == "object":
        more = schema.get("additionalProperties", {})
        kinds = more.get("type") if isinstance(more, dict) else None
        found = "Mapping[str, float | None]" if kinds == ["number", "null"] else "Mapping[str, Any]"
    elif isinstance(of, str):
        found = names[of]
    elif "anyOf" in schema:
        return "Mapping[str, Any] | None"
    else:
        found = "Mapping[str, Any]"
    return f"{found} | None" if optional else found


def design() -> str:
    """The text of `_design.py`."""
    schema = json.loads((HERE.parent / "docs" / "schema.json").read_text())["$defs"]["Design"]
    required = set(schema["required"])
    # A candidate was solved: what solving gave is there.
    solved = {"window", "binds", "binds_at", "windows", "shadow_prices", "sensitivity", "certificate"}
    out = '"""A design: a motor with its ratio or gear at a joint."""\n\n' + HEAD
    out += LIGHT.replace("    from os import PathLike\n", "").replace("\n    from gearwise._native import Motion\n", "")
    out += "\nfrom gearwise._light import final\nfrom gearwise._table import Record\n"
    about = (
        "A motor with its ratio or gear at a joint. Its attributes are the keys of the JSON, in SI with the unit in "
        "the name; what is not known is None."
    )
    out += "\n\n@final\nclass Design(Record):\n" + wrapped(about, "    ") + "\n    __slots__ = ()\n\n"
    for key, of in schema["properties"].items():
        out += f'    {key}: "{typed(of, key not in required | solved)}"\n'
        text = of.get("description", "")
        out += wrapped((text[:1].upper() + text[1:]).rstrip(".") + ".", "    ")
    return out


def main() -> int:
    """Writes the files, or checks them."""
    wrong = 0
    for name, text in [("_words.py", words()), ("_design.py", design())]:
        path = HERE / "gearwise" / name
        if "--check" not in sys.argv:
            path.write_text(text)
        elif path.read_text() != text:
            print(f"{path.name} is not what the program says: run python/generate.py", file=sys.stderr)
            wrong = 1
    return wrong


if __name__ == "__main__":
    sys.exit(main())
