"""Curves and spike trains: against definitions written down plainly."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_lab.comparison.metric import dtw_distance, filtered_trains

curves = st.integers(0, 10_000).map(
    lambda seed: np.random.Generator(np.random.Philox(seed)).normal(size=(8, 2)).cumsum(axis=0)
)


def plain_dtw(a: np.ndarray, b: np.ndarray) -> float:
    """The recursion as Sakoe and Chiba write it, without a band."""

    @cache
    def g(i: int, j: int) -> float:
        if i < 0 or j < 0:
            return 0.0 if i == j == -1 else np.inf
        d = float(np.linalg.norm(a[i] - b[j]))
        return min(g(i - 1, j) + d, g(i, j - 1) + d, g(i - 1, j - 1) + 2 * d)

    return g(len(a) - 1, len(b) - 1) / (len(a) + len(b))


@settings(max_examples=30)
@given(curves, curves)
def test_dtw_is_the_best_alignment(a: np.ndarray, b: np.ndarray) -> None:
    assert dtw_distance(a, b, band=1.0) == pytest.approx(plain_dtw(a, b))
    assert dtw_distance(a, b) == pytest.approx(dtw_distance(b, a))
    assert dtw_distance(a, b) >= dtw_distance(a, b, band=1.0) - 1e-12
    assert dtw_distance(a, a) == 0.0


def test_dtw_forgives_who_runs_ahead() -> None:
    t = np.linspace(0, 6, 100)
    way, late = np.column_stack([t, np.sin(t)]), np.column_stack([t - 0.3, np.sin(t - 0.3)])
    apart = np.linalg.norm(way - late, axis=1).mean()
    assert dtw_distance(way, late) < 0.2 * apart


@pytest.mark.parametrize("late_s", [0.0, 0.002, 0.02, 0.5])
def test_the_distance_of_two_spikes_is_van_rossums(late_s: float) -> None:
    one = filtered_trains([np.array([0.1])], 1.0, 0.02, 1e-4)
    other = filtered_trains([np.array([0.1 + late_s])], 1.0, 0.02, 1e-4)
    expected = np.sqrt(2 * (1 - np.exp(-late_s / 0.02)))
    assert np.linalg.norm(one - other) == pytest.approx(expected, abs=0.01)
    assert np.linalg.norm(one) == pytest.approx(1.0, abs=0.01)


def test_silent_trains_are_flat() -> None:
    assert not filtered_trains([np.empty(0), np.empty(0)], 0.1, 0.02).any()
