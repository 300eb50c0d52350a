"""Answers that came from another process: what they say, without what they were worked out from."""

from gearwise import _native
from gearwise._errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


def state(of: "Any") -> "dict[str, Any]":
    """What of an answer goes into another process."""
    if isinstance(of, Kept):
        return of.state
    joints = of.joints()
    return {
        "version": _native.__version__,
        "satisfied": of.satisfied,
        "warnings": of.warnings(),
        "json": of.to_json(),
        "csv": of.csv(),
        "text": of.text(),
        "headline": of.headline(),
        "joints": joints,
        "candidates": [of.candidates(place) for place in range(len(joints))],
        "without": [of.without(place) for place in range(len(joints))],
    }


class Kept:
    """The forms of an answer that was pickled. Pages and pictures are made where it was answered."""

    __slots__ = ("state", "_dict")

    def __init__(self, state: "dict[str, Any]") -> None:
        """Of what `state` gave; another version is refused."""
        if state["version"] != _native.__version__:
            raise InputError._said(
                f"this answer was pickled by gearwise {state['version']}, and this is {_native.__version__}"
            )
        self.state = state
        self._dict: "Any" = None

    @property
    def satisfied(self) -> bool:
        """As of the answer."""
        return bool(self.state["satisfied"])

    def to_dict(self) -> "Any":
        """As of the answer."""
        import json

        if self._dict is None:
            self._dict = json.loads(self.state["json"])
        return self._dict

    def design(self, joint: int, place: int) -> "Any":
        """As of the answer."""
        if place >= self.state["candidates"][joint]:
            return None
        return self.to_dict()["joints"][joint]["candidates"][place]

    def candidates(self, joint: int) -> int:
        """As of the answer."""
        return int(self.state["candidates"][joint])

    def without(self, joint: int) -> str:
        """As of the answer."""
        return str(self.state["without"][joint])

    def __getattr__(self, name: str) -> "Any":
        names = {"to_json": "json", "csv": "csv", "text": "text", "headline": "headline", "warnings": "warnings", "joints": "joints"}
        if name in names:
            return lambda: self.state[names[name]]
        if name.startswith("__"):
            raise AttributeError(name)
        return _elsewhere


def _elsewhere(*_: object) -> "NoReturn":
    raise InputError._said(
        "this answer came from another process, with what it says and not with what it was worked out from: "
        "make pages, pictures and exports where it was answered"
    )


def needed(of: "Any") -> "Any":
    """The answer of the library, for what needs more than what it says."""
    return _elsewhere() if isinstance(of, Kept) else of
