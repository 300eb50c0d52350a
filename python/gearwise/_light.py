"""What `typing` says to type checkers, without the time that it takes to load."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import final as final
    from typing import overload as overload
else:

    def final(of):
        """As `typing.final`."""
        return of

    def overload(of):
        """As `typing.overload`."""
        return of
