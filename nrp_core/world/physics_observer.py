"""Observers of bodies at the physics steps of a world, between two steps of the loop."""

from __future__ import annotations

from typing import Protocol

from nrp_core.clock import NS_PER_S

_FACTOR, _MORE_M_S = 2.0, 2.0


class PhysicsObserver(Protocol):
    """An object that looks at bodies in the middle of a step; see :meth:`.World.add_physics_observer`.

    The world calls :meth:`observe` at the first physics step at or after :attr:`deadline_ns`, after the
    samples of that time. The observer sets the next time then, and may set it between two steps of the loop.
    It reads the engine and changes nothing.

    Attributes:
        deadline_ns: when it looks next, ns; None: never. A time that has passed means the next physics step.
    """

    deadline_ns: int | None

    def observe(self, now_ns: int) -> None:
        """Look at the bodies, and set :attr:`deadline_ns`."""


def unchanged_ns(gap_m: float, speed_m_s: float) -> int:
    """Return for how long a distance keeps on the same side of a limit, ns.

    The bound holds as long as the speed does not exceed twice its present value plus 2 m/s. A body at rest
    that reaches this within a loop step of 20 ms is accelerated at 100 m/s^2.

    Args:
        gap_m: how far the distance is from the limit, m.
        speed_m_s: the speed of the body, m/s; of two bodies, the sum of both.
    """
    return int(abs(gap_m) / (_FACTOR * speed_m_s + _MORE_M_S) * NS_PER_S)
