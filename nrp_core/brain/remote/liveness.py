"""Detects whether a process is active, by the CPU time that it and its children have used."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

_STATE: Final = 0
"""Indices of the fields after the program's name in ``/proc/PID/stat``, see proc(5)."""
_TIMES: Final = slice(11, 15)
"""CPU time in user and system mode, of the process and of its finished children."""
_LOOKS: Final = 4


class Watchdog:
    """Detects that a process has been inactive for so long that it will not answer any more.

    It counts checks instead of reading a clock, so time for which this program or the machine was suspended
    does not count.

    Args:
        pid: the process id.
        limit_s: how long it may be inactive, s.
        error: the error to raise then.
    """

    def __init__(self, pid: int, limit_s: float, error: Callable[[], Exception]) -> None:
        self.between_looks_s = limit_s / _LOOKS
        self._pid, self._error = pid, error
        self._spent, self._idle = -1, 0

    def begin(self) -> None:
        """Restart the count: the process has received a request."""
        self._spent, self._idle = -1, 0

    def look(self) -> None:
        """Check whether the process has been active since the last check.

        Raises:
            Exception: it has been inactive for too long.
        """
        spent, busy = activity(self._pid)
        self._idle = self._idle + 1 if spent == self._spent and not busy else 0
        self._spent = spent
        if self._idle >= _LOOKS - 1:
            raise self._error()


def activity(pid: int) -> tuple[int, bool]:
    """Return the activity of a process and all its descendants.

    Returns:
        The CPU time used, in clock ticks, and whether one of them is runnable or waits for a disk.
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
