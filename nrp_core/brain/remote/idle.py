"""Processes whose brain has been closed, kept for the next brain: starting one takes seconds."""

from __future__ import annotations

import atexit
import os
import threading
from typing import Final

from nrp_core.brain.remote.process import BrainProcess, Kind

_KEPT: Final = 2
"""Maximum number of idle processes."""

_idle: Final[list[BrainProcess]] = []
_taking: Final = threading.Lock()


def borrow(python: str, module: str, time_limit_s: float) -> BrainProcess:
    """Return a process without a brain, a new one if none of this kind is idle.

    Args:
        python: the interpreter: a path, or a name on the search path.
        module: the module of the backend.
        time_limit_s: how long it may neither answer nor compute, s.

    Raises:
        BackendLoadError: the interpreter is not a program that can be run.
    """
    kind = Kind.of(python, module, time_limit_s)
    while (process := _take(kind)) is not None:
        if process.lives:
            return process
        process.close()
    return BrainProcess(kind)


def _take(kind: Kind) -> BrainProcess | None:
    """Remove an idle process of a kind, if there is one; runs in several threads may ask at once."""
    with _taking:
        found = next((process for process in _idle if process.kind == kind), None)
        if found is not None:
            _idle.remove(found)
        return found


def give_back(process: BrainProcess) -> None:
    """Close the brain of a process, and keep the process unless it has failed; end the longest idle one."""
    if process.close_brain():
        _idle.append(process)
    else:
        process.close()
    if len(_idle) > _KEPT:
        _idle.pop(0).close()


@atexit.register
def end_idle() -> None:
    """End the idle processes; called at the end of this process."""
    while _idle:
        _idle.pop().close()


os.register_at_fork(after_in_child=_idle.clear)  # they are the parent's
