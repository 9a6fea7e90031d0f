"""A request to end this process, which is remembered until a run has ended."""

from __future__ import annotations

import signal

asked = False
"""Whether a signal asked this process to end."""

TYPE_CHECKING = False  # as in .lazy: every start of the command line imports this
if TYPE_CHECKING:
    from types import FrameType


def interrupt(number: int, frame: FrameType | None) -> None:
    """Handle a signal as Ctrl-C is handled, and remember it.

    An exception is lost where C code calls Python, as in destructors and in callbacks of the compiler: the
    next step of the run raises it again.

    Raises:
        KeyboardInterrupt: always.
    """
    global asked
    asked = True
    signal.default_int_handler(number, frame)
