"""Tables, records and words: what the classes of the package stand on."""

from gearwise import _native

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from typing import Any

    from numpy.typing import NDArray


class Words:
    """Keys of a table of a requirement; immutable."""

    __slots__: "tuple[str, ...]" = ()
    _keys: "dict[str, str]" = {}

    def _fill(self, **words: object) -> None:
        for name, value in words.items():
            object.__setattr__(self, name, value)

    def _table(self) -> "dict[str, object]":
        """As the table of a file; what was left out is left out."""
        table: dict[str, object] = {}
        for name in self.__slots__:
            value = getattr(self, name)
            if value is None:
                continue
            if name == "ratio" and not hasattr(value, "items"):
                if not isinstance(value, tuple) or len(value) != 2:
                    from gearwise._errors import InputError

                    raise InputError._said(
                        f'`ratio` is {value!r}: expected (least, most), or a mapping as {{"values": [5, 7.5, 10]}}'
                    )
                value = {"min": value[0], "max": value[1]}
            if name == "bus" and not (hasattr(value, "items") or isinstance(value, Words)):
                from gearwise._errors import InputError

                raise InputError._said(f"`bus` is {value!r}: expected a Bus, as Bus({value!r}), or a mapping")
            if name == "ambient" and not isinstance(value, dict):
                value = {"temperature": value}
            table[self._keys.get(name, name)] = value
        return table

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable: make another one")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable")

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and all(
            getattr(self, name) == getattr(other, name) for name in self.__slots__
        )

    def __hash__(self) -> int:
        return hash((type(self).__name__, repr(self)))

    def __repr__(self) -> str:
        given = ((name, getattr(self, name)) for name in self.__slots__)
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in given if value is not None)})"

    def __getstate__(self) -> "dict[str, object]":
        return {name: getattr(self, name) for name in self.__slots__}

    def __setstate__(self, state: "dict[str, object]") -> None:
        self._fill(**state)


class Record:
    """Values of an answer by their names."""

    __slots__ = ("_values",)
    _values: "dict[str, Any]"

    def __init__(self, values: "Mapping[str, Any]") -> None:
        """Of the values of the JSON."""
        object.__setattr__(self, "_values", dict(values))

    if not TYPE_CHECKING:

        def __getattr__(self, name):
            values = object.__getattribute__(self, "_values")
            if name in values:
                value = values[name]
                pair = isinstance(value, list) and name == "window"
                return tuple(value) if pair else value
            if name in type(self).__annotations__:
                return None
            if name.startswith("_"):
                raise AttributeError(name)
            # The usual mistake is the unit that is left out.
            near = [known for known in dir(type(self)) + list(values) if known.startswith(f"{name}_")]
            hint = f": did you mean {' or '.join(f'`{known}`' for known in sorted(set(near))[:3])}?" if near else ""
            raise AttributeError(f"{type(self).__name__} has no `{name}`{hint}")

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable")

    def __dir__(self) -> "list[str]":
        return sorted({*object.__dir__(self), *self._values})

    def to_dict(self) -> "dict[str, Any]":
        """The values as the JSON has them."""
        return dict(self._values)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and isinstance(other, Record) and self._values == other._values

    def __hash__(self) -> int:
        return hash((self._values.get("motor"), self._values.get("ratio")))

    def __repr__(self) -> str:
        motor, gear, ratio = (self._values.get(name) for name in ("motor", "gear", "ratio"))
        at = f" with {gear}" if gear else f" at N = {ratio:.6g}" if isinstance(ratio, float) else ""
        return f"<{type(self).__name__} {motor}{at}>"

    def __getstate__(self) -> "dict[str, Any]":
        return self._values

    def __setstate__(self, state: "dict[str, Any]") -> None:
        object.__setattr__(self, "_values", state)


class Table:
    """Columns of one length: `polars.DataFrame(t)` and `pyarrow.table(t)` take it as it is. What is not known is NaN,
    in texts None; in Arrow both are null."""

    __slots__ = ("_made",)
    _made: "_native.Table | None"

    def __init__(self, made: "_native.Table | None" = None) -> None:
        """Of a table of the library."""
        self._made = made

    def _native_table(self) -> "_native.Table":
        assert self._made is not None
        return self._made

    def __len__(self) -> int:
        return len(self._native_table())

    def columns(self) -> "dict[str, NDArray[Any]]":
        """The columns as arrays, by their names: numbers as float64, whole numbers as int64, texts as objects."""
        return self._native_table().columns()

    def to_pandas(self) -> "Any":
        """As a `pandas.DataFrame`; needs pandas, and no pyarrow."""
        import pandas

        return pandas.DataFrame(self.columns())

    def to_arrow(self) -> "Any":
        """As a `pyarrow.Table`; needs pyarrow."""
        import pyarrow

        return pyarrow.table(self)

    def __arrow_c_stream__(self, requested_schema: "object | None" = None) -> object:
        """The table as a stream of the Arrow C data interface."""
        return self._native_table().__arrow_c_stream__(requested_schema)

    def _rows(self, most: int) -> "Iterator[tuple[Any, ...]]":
        columns = list(self._native_table().columns().values())
        for place in range(min(len(self), most)):
            yield tuple(column[place] for column in columns)

    def __repr__(self) -> str:
        names = self._native_table().names
        return f"<{type(self).__name__} of {len(self)} rows: {', '.join(names[:8])}{', …' if len(names) > 8 else ''}>"

    def _repr_html_(self) -> str:
        from gearwise._html import table_html

        return table_html(self._native_table().names, list(self._rows(10)), len(self))
