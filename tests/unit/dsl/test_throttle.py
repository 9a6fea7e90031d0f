"""A throttled function keeps its mean rate exactly."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from nrp_core.dsl.functions import Throttle

MS = 1_000_000


def runs(rate_hz: float | None, period_ns: int, steps: int) -> list[int]:
    throttle = Throttle(rate_hz)
    return [k for k in range(steps) if throttle.admits(k * period_ns)]


def test_30_hz_at_steps_of_20_ms_alternates_to_keep_30_hz() -> None:
    assert runs(30, 20 * MS, 12) == [0, 2, 4, 5, 7, 9, 10]
    assert len(runs(30, 20 * MS, 5000)) == 3000


def test_without_a_rate_every_step_runs() -> None:
    assert runs(None, 20 * MS, 4) == [0, 1, 2, 3]


@given(
    rate_hz=st.floats(0.1, 2000),
    period_ms=st.integers(1, 100),
    steps=st.integers(1, 300),
)
def test_after_any_time_the_number_of_runs_is_that_of_the_periods_begun(
    rate_hz: float, period_ms: int, steps: int
) -> None:
    rate, period_s = Fraction(repr(rate_hz)), Fraction(period_ms, 1000)
    if rate * period_s <= 1:
        assert len(runs(rate_hz, period_ms * MS, steps)) == int((steps - 1) * period_s * rate) + 1
    else:
        assert len(runs(rate_hz, period_ms * MS, steps)) == steps


def test_reset_admits_at_once_again() -> None:
    throttle = Throttle(1)
    assert throttle.admits(0)
    assert not throttle.admits(500 * MS)
    throttle.reset()
    assert throttle.admits(0)
