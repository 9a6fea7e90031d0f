"""Times and synapses in the order of a simulator.

With a fixed time step, events within a step take effect at its end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import NS_PER_MS, milliseconds, nanoseconds
from nrp_core.errors import TimestepError

_LAST: Final = "weight"
Time = TypeVar("Time", int, IntArray)


def same_order(
    ours: Mapping[str, npt.ArrayLike], theirs: Mapping[str, npt.ArrayLike]
) -> tuple[IntArray, IntArray]:
    """Return two orders that put the synapses of both sides in the same sequence.

    Synapses of equal ends, delays and parameters differ only in their weights. Plasticity may have changed
    these, but not their order, because all such synapses see the same spikes.

    Args:
        ours: values of the synapses by name, each of shape ``(n,)``, including ``weight``.
        theirs: the same values of the same synapses, equal to the last bit, in another order.
    """
    names = [_LAST, *(name for name in ours if name != _LAST)]
    first, second = (np.lexsort([np.atleast_1d(side[name]) for name in names]) for side in (ours, theirs))
    return first, second


def nearest_ns(times_ns: Time, step_ns: int) -> Time:
    """Return the multiple of a step that is nearest to each time; of two, the later one."""
    return (times_ns + step_ns // 2) // step_ns * step_ns


ROUNDING: Final = 1e-6
"""Tolerance for a time on the grid, in steps."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Equidistant points in time.

    Args:
        step_ns: distance of the points.
        owner: the simulator's name, for messages, e.g. ``NEST``.
    """

    step_ns: int
    owner: str = "the brain"

    @property
    def step_ms(self) -> float:
        """Distance of the points, ms."""
        return milliseconds(self.step_ns)

    def first_at(self, times_ms: FloatArray) -> IntArray:
        """Return the number of the first point at or after each time."""
        return np.ceil(times_ms * (NS_PER_MS / self.step_ns) - ROUNDING).astype(np.int64)

    def time_ms(self, numbers: IntArray) -> FloatArray:
        """Return the times of points."""
        times: FloatArray = numbers * self.step_ns / NS_PER_MS
        return times

    def nearest(self, times_ms: npt.ArrayLike) -> IntArray:
        """Return the number of the point nearest to each time; of two points, the later one."""
        return nearest_ns(nanoseconds(times_ms), self.step_ns) // self.step_ns

    def delays(self, delays_ms: FloatArray) -> IntArray:
        """Return delays in steps, rounded to the nearest number, at least one."""
        return np.maximum(self.nearest(delays_ms), 1)

    def number_of(self, t_ns: int) -> int:
        """Return the number of the point at a time.

        Raises:
            TimestepError: the time is not on the grid.
        """
        number, rest = divmod(t_ns, self.step_ns)
        if rest:
            raise TimestepError(
                f"{self.owner} runs in steps of {self.step_ms:g} ms "
                f"and cannot stop at {milliseconds(t_ns):g} ms"
            )
        return number
