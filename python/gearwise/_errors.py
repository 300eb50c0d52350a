"""What goes wrong."""

from gearwise._light import final

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


@final
class Problem:
    """One mistake in what was read or handed over."""

    __slots__ = ("message", "label", "help", "file", "line", "column", "key")

    message: str
    """What is wrong, in one line."""
    label: str
    """What was expected; may be empty."""
    help: "str | None"
    """What to do about it."""
    file: "str | None"
    """The file; None for values that were handed over."""
    line: "int | None"
    """Its line, from 1."""
    column: "int | None"
    """Its column in characters, from 1."""
    key: "str | None"
    """The path of the key, as `joint "knee".ratio.max`, in values that were handed over."""

    def __init__(
        self,
        message: str,
        label: str = "",
        help: "str | None" = None,
        file: "str | None" = None,
        line: "int | None" = None,
        column: "int | None" = None,
        key: "str | None" = None,
    ) -> None:
        """A mistake with its place."""
        self.message = message
        self.label = label
        self.help = help
        self.file = file
        self.line = line
        self.column = column
        self.key = key

    def __repr__(self) -> str:
        place = self.key or (f"{self.file}:{self.line}:{self.column}" if self.line else self.file or "")
        return f"<Problem {place + ': ' if place else ''}{self.message}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Problem) and all(
            getattr(self, name) == getattr(other, name) for name in self.__slots__
        )

    def __hash__(self) -> int:
        return hash(tuple(getattr(self, name) for name in self.__slots__))


class GearwiseError(Exception):
    """Whatever gearwise refuses or cannot do."""


class InputError(GearwiseError, ValueError):
    """Mistakes in files, values or arguments: all of them at once. Its text is what the command line prints."""

    problems: "tuple[Problem, ...]" = ()
    """The mistakes, each with its place."""

    @classmethod
    def _of(cls, problems: "Sequence[Problem]", text: str) -> "InputError":
        made = cls(text)
        made.problems = tuple(problems)
        return made

    @classmethod
    def _said(cls, message: str) -> "InputError":
        return cls._of([Problem(message)], message)

    def __reduce__(self) -> "tuple[object, ...]":
        return (InputError._of, (self.problems, str(self)))


class NoDesign(GearwiseError, LookupError):
    """A joint has no design: its text says which motor came nearest, and why that cannot do it."""


class InternalError(GearwiseError, RuntimeError):
    """A mistake of gearwise: please report it."""
