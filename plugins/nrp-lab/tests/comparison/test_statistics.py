"""Estimates, tests and distances against independent sources."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_lab.comparison.judgement import (
    Estimate,
    excess_of_shift,
    excess_values,
    holm,
    pooled_sd,
    shift_of_excess,
)
from scipy import stats

values = st.lists(st.floats(-100, 100), min_size=3, max_size=12).map(np.array)


@given(values.filter(lambda v: np.std(v) > 1e-3), st.floats(0.01, 200))
def test_the_tests_are_those_of_scipy(given_values: np.ndarray, margin: float) -> None:
    estimate = Estimate.of(given_values)
    assert estimate.p_different == pytest.approx(stats.ttest_1samp(given_values, 0).pvalue, abs=1e-9)
    low = stats.ttest_1samp(given_values, -margin, alternative="greater").pvalue
    high = stats.ttest_1samp(given_values, margin, alternative="less").pvalue
    assert estimate.p_equivalent(margin) == pytest.approx(max(low, high), abs=1e-9)


@given(values.filter(lambda v: np.std(v) > 1e-3), st.floats(0.01, 200))
def test_equivalence_means_that_the_interval_lies_inside_the_margin(
    given_values: np.ndarray, margin: float
) -> None:
    estimate = Estimate.of(given_values)
    low, high = estimate.interval
    p = estimate.p_equivalent(margin)
    if abs(p - 0.05) > 1e-6:
        assert (p < 0.05) == (-margin < low and high < margin)


def test_without_spread_only_the_numbers_themselves_count() -> None:
    same, other = Estimate.of(np.zeros(3)), Estimate.of(np.full(3, 0.5))
    assert (same.p_different, same.p_equivalent(0.0)) == (1.0, 0.0)
    assert (other.p_different, other.p_equivalent(0.5), other.p_equivalent(0.4)) == (0.0, 0.0, 1.0)


def test_one_seed_is_not_enough_for_a_verdict() -> None:
    estimate = Estimate.of(np.array([5.0]))
    assert (estimate.p_different, estimate.p_equivalent(100.0)) == (1.0, 1.0)
    assert estimate.interval == (-np.inf, np.inf)


@given(st.integers(0, 20), st.integers(0, 20), st.integers(0, 20))
def test_matched_shares_are_those_of_agresti_and_min(b: int, c: int, same: int) -> None:
    n = b + c + same
    if n < 2:
        return
    estimate = Estimate.from_matched_shares(np.array([1.0] * c + [-1.0] * b + [0.0] * same))
    error = np.sqrt((b + c + 1) - (c - b) ** 2 / (n + 2)) / (n + 2)  # as published
    assert estimate.mean == pytest.approx((c - b) / (n + 2))
    assert estimate.error == pytest.approx(error)


def test_holm_multiplies_by_how_many_are_left() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([]) == []
    assert holm([0.9, 0.9]) == [1.0, 1.0]


def test_the_pooled_spread_is_the_root_of_the_mean_variance() -> None:
    assert pooled_sd([3.0, 4.0]) == pytest.approx(np.sqrt(12.5))
    assert pooled_sd([]) == 0.0


@pytest.mark.parametrize("shift", [0.0, 0.5, 1.0, 2.0])
def test_the_excess_of_a_shift_is_that_of_normal_samples(shift: float) -> None:
    rng = np.random.Generator(np.random.Philox(3))
    a, b, c = rng.normal(size=(3, 200_000))
    found = np.abs(a - b - shift).mean() / np.abs(a - c).mean() - 1
    assert excess_of_shift(shift) == pytest.approx(found, abs=0.01)
    assert shift_of_excess(excess_of_shift(shift)) == pytest.approx(shift, abs=1e-3)


def test_one_standard_deviation_is_an_excess_of_a_quarter() -> None:
    assert excess_of_shift(1.0) == pytest.approx(0.2401, abs=1e-4)
    assert shift_of_excess(-0.1) == 0.0


@given(st.integers(3, 8), st.integers(0, 1000))
def test_pseudo_values_are_those_of_leaving_each_seed_out(n: int, seed: int) -> None:
    rng = np.random.Generator(np.random.Philox(seed))
    x, y = rng.normal(size=(2, n))
    within_a, within_b = np.abs(x[:, None] - x), np.abs(y[:, None] - y)
    between = np.abs(x[:, None] - y)

    def excess(kept: list[int]) -> float:
        pairs = [(s, t) for s in kept for t in kept if s != t]
        return float(np.mean([between[s, t] - (within_a[s, t] + within_b[s, t]) / 2 for s, t in pairs]))

    everyone = list(range(n))
    whole = excess(everyone)
    found = excess_values(within_a, between, within_b)
    assert found.mean() == pytest.approx(whole)
    assert found == pytest.approx(
        [n * whole - (n - 1) * excess([s for s in everyone if s != i]) for i in everyone]
    )
