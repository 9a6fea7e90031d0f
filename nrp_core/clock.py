"""Time: integer nanoseconds, steps that divide, and samples that need not.

Engine time counts nanoseconds since reset in ``int``; nothing is accumulated in floating point.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import TimestepError

NS_PER_S = 1_000_000_000
NS_PER_MS = 1_000_000
MS_PER_S = 1000.0
_NANOSECOND_EXACT_S = 2.0**21
_NANOSECOND_EXACT_MS = 2.0**31
"""Floats below these are less than half a nanosecond apart."""
FOREVER_NS: Final = 2**61
"""73 years: a time that is never reached. A later time, as infinity, counts as this one."""


def seconds(t_ns: int) -> float:
    """Convert nanoseconds to seconds."""
    return t_ns / NS_PER_S


def milliseconds(t_ns: int) -> float:
    """Convert nanoseconds to milliseconds."""
    return t_ns / NS_PER_MS


def from_seconds(t_s: float | Fraction) -> int:
    """Convert seconds to the nearest nanosecond, reading a float by its shortest decimal form."""
    if isinstance(t_s, float) and -_NANOSECOND_EXACT_S < t_s < _NANOSECOND_EXACT_S:
        t_ns = round(t_s * NS_PER_S)
        if t_ns / NS_PER_S == t_s:  # the shortest form is closer to it than half a nanosecond
            return t_ns
    exact = t_s if isinstance(t_s, Fraction) else Fraction(repr(float(t_s)))
    return round(exact * NS_PER_S)


def from_milliseconds(t_ms: float) -> int:
    """Convert milliseconds to the nearest nanosecond, reading a float by its shortest decimal form."""
    if -_NANOSECOND_EXACT_MS < t_ms < _NANOSECOND_EXACT_MS:  # as in from_seconds
        t_ns = round(t_ms * NS_PER_MS)
        if t_ns / NS_PER_MS == t_ms:
            return t_ns
    return from_seconds(Fraction(repr(float(t_ms))) / 1000)


def nanoseconds(times_ms: npt.ArrayLike) -> IntArray:
    """Convert times, ms, to nanoseconds as :func:`from_milliseconds` does; later ones are :data:`FOREVER_NS`.

    Compare two times by these numbers: the last bits of a computed float, as ``3 * 0.1``, are not those of
    the number that a person writes.

    Returns:
        Whole numbers in the shape of the times.
    """
    given = np.asarray(times_ms, float)
    product = given * NS_PER_MS
    whole = np.rint(product)
    with np.errstate(invalid="ignore"):  # infinity
        is_sure = np.abs(np.abs(product - whole) - 0.5) > np.abs(product) * 2.0**-51  # else it may be a tie
    found = np.where(is_sure, whole, 0.0).astype(np.int64)
    for place in np.argwhere(~is_sure):
        found[tuple(place)] = _bounded_ns(float(given[tuple(place)]))
    return found


def _bounded_ns(t_ms: float) -> int:
    bound_ms = milliseconds(FOREVER_NS)
    return FOREVER_NS if t_ms >= bound_ms else -FOREVER_NS if t_ms <= -bound_ms else from_milliseconds(t_ms)


def without_rounding_errors(times_ms: npt.ArrayLike) -> FloatArray:
    """Return times, ms, where those that differ from whole nanoseconds by rounding errors are these.

    Times between two nanoseconds stay as they are.
    """
    given = np.asarray(times_ms, float)
    nearest: FloatArray = nanoseconds(given) / NS_PER_MS
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(given - nearest) <= 8.0 * np.spacing(np.abs(given)), nearest, given)


def dividing_step(step_ns: int, period_ns: int) -> int:
    """Return the longest step up to a given one that divides a period; that one if all are far shorter."""
    fewest = -(-period_ns // step_ns)
    return next((period_ns // n for n in range(fewest, 4 * fewest + 1) if period_ns % n == 0), step_ns)


@dataclass(frozen=True, slots=True)
class StepPlan:
    """The period of the closed loop and the steps of both sides, checked to divide.

    Args:
        period_ns: one step of the closed loop.
        brain_step_ns: the grid of the brain, or None where any time can be reached.
        world_step_ns: the physics step of the world, or None where any time can be reached.

    Raises:
        TimestepError: a step is not positive or the period is not a multiple of it.
    """

    period_ns: int
    brain_step_ns: int | None = None
    world_step_ns: int | None = None

    def __post_init__(self) -> None:
        steps = (self.period_ns, self.brain_step_ns, self.world_step_ns)
        positive = all(step is None or step > 0 for step in steps)
        if not positive or any(step and self.period_ns % step for step in steps[1:]):
            raise TimestepError(
                f"the loop's period of {_in_ms(self.period_ns)} must be a positive multiple of the "
                f"brain's step ({_in_ms(self.brain_step_ns)}) and of the world's step "
                f"({_in_ms(self.world_step_ns)})"
            )


def _in_ms(t_ns: int | None) -> str:
    return "any" if t_ns is None else f"{milliseconds(t_ns):g} ms"


@dataclass(frozen=True, slots=True)
class SampleSchedule:
    """The times of samples at a rate, on a grid of steps that the rate need not divide.

    Sample ``k`` is taken at the first multiple of ``step_ns`` at or after ``k / rate_hz``, in
    rational arithmetic, so the mean rate is exact and never drifts.

    Args:
        rate_hz: samples per second, positive.
        step_ns: the grid.
    """

    rate_hz: Fraction
    step_ns: int
    _rate: int = field(init=False, repr=False, compare=False)
    _per_ns: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # integers, computed once: fractions are many times slower
        object.__setattr__(self, "_rate", self.rate_hz.numerator)
        object.__setattr__(self, "_per_ns", self.rate_hz.denominator * NS_PER_S)

    @classmethod
    def of(cls, rate_hz: float, step_ns: int) -> SampleSchedule:
        """Build a schedule from a float rate, read by its shortest decimal form."""
        return cls(Fraction(repr(float(rate_hz))), step_ns)

    def sample_ns(self, k: int) -> int:
        """Time at which sample ``k`` (0, 1, ...) is taken."""
        step_ns = self.step_ns
        return -((-k * self._per_ns) // (self._rate * step_ns)) * step_ns

    def index_at(self, t_ns: int) -> int:
        """The number of the last sample due by ``t_ns``."""
        return t_ns * self._rate // self._per_ns

    def next_after(self, t_ns: int) -> int:
        """Time of the first sample strictly after ``t_ns``."""
        k = (t_ns - t_ns % self.step_ns) * self._rate // self._per_ns + 1
        return self.sample_ns(k if k > 0 else 0)
