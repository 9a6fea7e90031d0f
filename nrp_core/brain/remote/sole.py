"""Locks for simulators that can run once in a process."""

from __future__ import annotations

from typing import Final
from weakref import WeakValueDictionary

from nrp_core.errors import LifecycleError


class Sole:
    """Exclusive use of a simulator in this process, until it is released or garbage-collected.

    Args:
        simulator: its name, the same for every backend that drives it, e.g. ``NEST``.

    Raises:
        LifecycleError: another brain uses the simulator.
    """

    def __init__(self, simulator: str) -> None:
        if is_taken(simulator):
            raise LifecycleError(
                f"{simulator} is one to a process and another brain is using it; close that brain first, "
                "or give this one a process of its own with the option python, e.g. python: python3"
            )
        self._simulator = simulator
        _holders[simulator] = self

    def release(self) -> None:
        """Release the simulator; further calls do nothing."""
        if _holders.get(self._simulator) is self:
            del _holders[self._simulator]


_holders: Final[WeakValueDictionary[str, Sole]] = WeakValueDictionary()


def is_taken(simulator: str) -> bool:
    """Return whether a brain of this process is using a simulator."""
    return simulator in _holders
