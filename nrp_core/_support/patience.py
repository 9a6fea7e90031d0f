"""Wait for a child process as long as it may take, not counting when others had the processors."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

_LEAST_S: Final = 0.05


def ends_within(limit_s: float, pid: int, wait: Callable[[float], bool]) -> bool:
    """Return whether a process ends before it has run, slept and read for some time.

    On a machine that is busy with other programs, this is longer than the limit.

    Args:
        limit_s: the time, s.
        pid: the process.
        wait: waits for its end, for a time in s, and returns whether it has come.
    """
    began_s = time.monotonic()
    while (left_s := limit_s + _queued_s(pid) - (time.monotonic() - began_s)) > 0:
        if wait(max(left_s, _LEAST_S)):
            return True
    return False


def _queued_s(pid: int) -> float:
    """Return how long a process was ready to run and had no processor; 0 where the system does not say."""
    try:
        _, queued_ns, _ = Path(f"/proc/{pid}/schedstat").read_text("ascii").split()
    except (OSError, ValueError):
        return 0.0
    return int(queued_ns) / 1e9
