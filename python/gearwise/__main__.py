"""The command line: `gearwise`, or `python -m gearwise`."""

import os
import signal
import sys

from gearwise import _native


def main() -> int:
    """Runs the command line on the process's arguments; its exit status."""
    # Ctrl-C ends the program, as outside of Python: nothing of Python has to be put in order.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    name = os.path.basename(sys.argv[0])
    return _native.command([name if name != "__main__.py" else "gearwise", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
