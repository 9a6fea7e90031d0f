"""The search for threshold crossings against dense sampling of the same function."""

from collections.abc import Callable
from math import exp, inf

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from nrp_brain_event import rise
from nrp_brain_event.records import Work

from nrp_core.network.filters import driven

SAMPLES = 500


def searched(kind: int, coefficients: list[float], until: float) -> float:
    work = np.zeros(1, Work.dtype())
    work["function"][0, : len(coefficients)] = coefficients
    return rise.first_rise(kind, work[0], until)


def check(found: float, function: Callable[[float], float], until: float) -> None:
    """No sampled rise comes before the one that was found, and there the function is zero."""
    t = np.linspace(0.0, until, SAMPLES)
    values = np.array([function(x) for x in t])
    noise = 1e-10 * np.abs(values).max()
    below = np.flatnonzero(values < -noise)
    after = values[below[0] :] > noise if len(below) else np.empty(0, bool)
    if after.any():
        assert found <= t[below[0] + np.argmax(after)]
    if found < inf:
        assert abs(function(found)) <= 1e-8 * np.abs(values).max()
        assert function(found - 1e-9 * until) < noise
    else:
        assert not after.any()


times = st.floats(-1.0, 1.5).map(lambda power: 10.0**power)
amounts = st.one_of(st.just(0.0), st.floats(-3.0, 3.0))


@given(
    settled=st.floats(-2.0, 2.0), above=st.floats(-2.0, 2.0), tau_m=times,
    tau_e=times, tau_i=st.one_of(times, st.none()), x_e=amounts, s_e=amounts, x_i=amounts, s_i=amounts,
)  # fmt: skip
@example(-7.5, -7.5, 0.5, 0.5, None, 0.0, 0.0, 30.0, 0.0)
@example(-1.0, -1.0, 10.0, 10.0, None, 3.0, 0.0, -3.0, 0.0)
@settings(max_examples=60, deadline=None)
def test_the_first_rise_of_a_membrane_under_two_currents_is_found(
    settled: float, above: float, tau_m: float, tau_e: float, tau_i: float | None,
    x_e: float, s_e: float, x_i: float, s_i: float,
) -> None:  # fmt: skip
    tau_e = tau_e if x_e or s_e else tau_m
    tau_i = (tau_i or tau_e) if x_i or s_i else tau_e
    tau_e = tau_e if x_e or s_e else tau_i
    synapses = ((tau_e, x_e, s_e), (tau_i, x_i, s_i))

    def voltage(t: float) -> float:
        leak = exp(-t / tau_m)
        charge = sum(driven(t, leak, exp(-t / tau), 1 / tau - 1 / tau_m, x, s) for tau, x, s in synapses)
        return settled + above * leak + charge

    longest = max(tau_m, tau_e, tau_i)
    coefficients = [settled, above, tau_m, 1.0, tau_e, x_e, s_e, tau_i, x_i, s_i]
    found = searched(rise.RESPONSE, coefficients, 80.0 * longest)
    check(found, voltage, 80.0 * longest)
    check(found if found < 5.0 * longest else inf, voltage, 5.0 * longest)


@given(coefficients=st.lists(st.floats(-10.0, 10.0), min_size=5, max_size=5))
@example([-1.0, 0.0, 0.0, 0.0, 0.0])
@example([0.0, -1.0, 1.0, 0.0, 0.0])
@settings(max_examples=60, deadline=None)
def test_the_first_rise_of_a_polynomial_is_found(coefficients: list[float]) -> None:
    def value(t: float) -> float:
        return float(np.polynomial.polynomial.polyval(t, coefficients))

    check(searched(rise.POLYNOMIAL, coefficients, 1.0), value, 1.0)


def test_a_peak_that_lasts_a_millionth_of_the_time_is_not_missed() -> None:
    """The polynomial touches zero from below at a quarter and is lifted by next to nothing."""
    square = np.polynomial.Polynomial([0.25, -1.0]) ** 2
    lifted = -square * np.polynomial.Polynomial([1.0, 1.0, 1.0]) + 1e-13
    found = searched(rise.POLYNOMIAL, lifted.coef.tolist(), 1.0)
    assert found == pytest.approx(0.25, abs=1e-6)
    assert found < 0.25
    sunk = lifted - 2e-13
    assert searched(rise.POLYNOMIAL, sunk.coef.tolist(), 1.0) == inf
