"""Whether a process does anything: by the processor time that it and what it started have used."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

_STATE: Final = 0
"""Of the fields behind the name of the program in ``/proc/PID/stat``, see proc(5)."""
_TIMES: Final = slice(11, 15)
"""In user mode and in the system, its own and its children's that ended."""
_LOOKS: Final = 4


class Watchdog:
    """Notices that a process does nothing for so long that it will not answer any more.

    It counts looks and reads no clock: while this program was stopped itself, or the machine slept, nobody
    waited.

    Args:
        pid: of the process.
        limit_s: how long it may do nothing.
        error: what to raise then.
    """

    def __init__(self, pid: int, limit_s: float, error: Callable[[], Exception]) -> None:
        self.between_looks_s = limit_s / _LOOKS
        self._pid, self._error = pid, error
        self._spent, self._idle = -1, 0

    def begin(self) -> None:
        """The process has got something to do."""
        self._spent, self._idle = -1, 0

    def look(self) -> None:
        """Look whether it has done anything since the last look.

        Raises:
            Exception: it has not for too long.
        """
        spent, busy = activity(self._pid)
        self._idle = self._idle + 1 if spent == self._spent and not busy else 0
        self._spent = spent
        if self._idle >= _LOOKS - 1:
            raise self._error()


def activity(pid: int) -> tuple[int, bool]:
    """Return what a process and all below it do.

    Returns:
        The processor time they have used, in the system's ticks, and whether one of them would use more: it
        waits for a processor or a disk.
    """
    spent, busy = 0, False
    with suppress(OSError):  # one of them has just ended
        process = Path(f"/proc/{pid}")
        spent = sum(map(int, _fields(process)[_TIMES]))
        for task in process.glob("task/*"):
            busy |= _fields(task)[_STATE] in "RD"
            for child in (task / "children").read_text().split():
                more, also = activity(int(child))
                spent, busy = spent + more, busy or also
    return spent, busy


def _fields(process: Path) -> list[str]:
    return (process / "stat").read_text().rpartition(")")[2].split()
