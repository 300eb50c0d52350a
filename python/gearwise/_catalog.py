"""Catalogues of motors and gears."""

from gearwise import _native
from gearwise._errors import InputError
from gearwise._light import final
from gearwise._table import Table

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from os import PathLike
    from typing import Any


@final
class Catalog(Table):
    """Rows of motors and gears; immutable. As a table it has a row for each motor, with the columns of a catalogue file."""

    __slots__ = ("_catalog",)
    _catalog: "_native.Catalog"

    def __init__(
        self, *sources: "str | PathLike[str] | Catalog", estimates: bool = True, inside_modules: bool = False
    ) -> None:
        """Of files, folders and other catalogues, put together; none: the built-in one. The words "builtin" and "user" name
        that and your own. `estimates`: what a row lacks is estimated from rows built alike, and marked. `inside_modules`:
        motors that are only sold inside a module are a free choice too. Raises InputError with every mistake."""
        super().__init__()
        given = [source._catalog if isinstance(source, Catalog) else source for source in sources]
        self._catalog = _native.Catalog(*given, estimates=estimates, inside_modules=inside_modules)

    @staticmethod
    def _of(native: "_native.Catalog") -> "Catalog":
        made = Catalog.__new__(Catalog)
        made._made = None
        made._catalog = native
        return made

    @staticmethod
    def from_frame(
        frame: object, *, gears: object = None, estimates: bool = True, inside_modules: bool = False
    ) -> "Catalog":
        """Of a frame of motors, and one of gears: pandas, polars, or a mapping of columns. Its columns are those of a
        catalogue file, units in their names (`mass [kg]`); the conventions of the row are required. Raises InputError."""
        texts = [("motors of the frame", _csv(frame, "frame"))]
        if gears is not None:
            texts.append(("gears of the frame", _csv(gears, "gears")))
        return Catalog._of(_native.Catalog._of_text(texts, estimates, inside_modules))

    def filter(self, words: "str | Callable[[Mapping[str, Any]], bool]") -> "Catalog":
        """The same with some motors alone. Words all have to hold: `maxon` is in the id or the maker, `-flat` is not,
        `mass<0.5kg` compares a column, as `gearwise catalog list` does. Or a function of a row, by its columns."""
        table = self._native_table()
        columns = table.columns()
        ids = list(columns["id"])
        if callable(words):
            keep = [
                k for k in range(len(ids)) if words({name: column[k] for name, column in columns.items()})
            ]
            return Catalog._of(self._catalog._only([ids[k] for k in keep]))
        split = words.split()
        compared = [word for word in split if any(sign in word for sign in "<>=")]
        left = set(ids)
        if compared:
            left = set(_native.Table(self._catalog._csv("motor", compared)).columns()["id"])
        makers = columns["manufacturer"]

        def has(place: int, text: str) -> bool:
            return text in str(ids[place]).lower() or text in str(makers[place]).lower()

        for word in (word.lower() for word in split if word not in compared):
            bare = word.removeprefix("-")
            left &= {ids[k] for k in range(len(ids)) if has(k, bare) != word.startswith("-")}
        return Catalog._of(self._catalog._only([name for name in ids if name in left]))

    def _native_table(self) -> "_native.Table":
        if self._made is None:
            self._made = _native.Table(self._catalog._csv("motor", []))
        return self._made

    def __len__(self) -> int:
        return len(self._catalog)

    def __reduce__(self) -> "tuple[object, ...]":
        return (Catalog._of, (self._catalog,))

    def __repr__(self) -> str:
        return f"<Catalog of {len(self)} motors>"


def _csv(frame: "Any", name: str) -> str:
    """A frame as CSV."""
    import csv
    import io

    columns: "dict[str, Any]"
    if hasattr(frame, "to_pydict"):
        columns = {str(column): list(cells) for column, cells in frame.to_pydict().items()}
    elif hasattr(frame, "to_dict") and hasattr(frame, "columns"):
        columns = {str(column): list(frame[column]) for column in frame.columns}
    elif hasattr(frame, "items"):
        for column, cells in frame.items():
            if isinstance(cells, str) or not hasattr(cells, "__iter__"):
                raise InputError._said(f"`{name}`: column `{column}` is no list of values")
        columns = {str(column): list(cells) for column, cells in frame.items()}
    else:
        raise InputError._said(f"`{name}` is no frame: expected pandas, polars or a mapping of columns")
    if not columns:
        raise InputError._said(f"`{name}` has no columns")
    if len({len(cells) for cells in columns.values()}) > 1:
        raise InputError._said(f"`{name}`: its columns are not of one length")
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)

    def cell(value: object) -> str:
        # pandas has a value of its own for what is missing, which is neither equal nor unequal to itself.
        if value is None or type(value).__name__ == "NAType" or value != value:
            return ""
        return repr(float(value)) if isinstance(value, float) else str(value)

    writer.writerows([cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return out.getvalue()


_BUILTIN: "list[Catalog]" = []


def builtin(catalog: "Catalog | None") -> "_native.Catalog":
    """The catalogue of a call: the built-in one, which is read once, where none is given."""
    if catalog is not None:
        if not isinstance(catalog, Catalog):
            raise InputError._said("`catalog` is no Catalog: make one of files by Catalog(path)")
        return catalog._catalog
    if not _BUILTIN:
        _BUILTIN.append(Catalog())
    return _BUILTIN[0]._catalog
