"""The difference of two signals: level, delay and noise."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_lab.comparison.engines.signals import Signal

_WINDOW = 11
"""Steps of the moving mean that separates a signal into its level and its noise."""
_LAGS = 10
"""Maximum delay that is searched for, steps."""
_EXPLAINS = 0.2
"""A delay is accepted if the remaining difference is less than this share of the difference without it."""
_SILENT = 1e-3
"""Differences below this share of a signal are not searched for a delay."""


@dataclass(frozen=True, slots=True)
class SignalDifference:
    """The difference between a signal in two runs.

    Args:
        level_percent: mean difference of the smoothed signals without the delay, % of the amplitude.
        delay_s: delay of the other signal, s.
        noise_percent: root of the difference of the mean squares that smoothing removes, % of the
            amplitude.
    """

    level_percent: float
    delay_s: float
    noise_percent: float


MISSING = SignalDifference(inf, 0.0, 0.0)


def difference(one: Signal, other: Signal, step_s: float) -> SignalDifference | None:
    """Return the difference of two signals; None if they have no step in common."""
    if one.values.shape[1] != other.values.shape[1]:
        return MISSING
    steps = min(len(one.values), len(other.values))
    a, b = (np.where(np.isfinite(s.values[:steps]), s.values[:steps], np.nan) for s in (one, other))
    apart_in_presence = np.isfinite(a).mean() - np.isfinite(b).mean()
    seen = np.isfinite(a) & np.isfinite(b)
    if not seen.any():
        return None if not (np.isfinite(a).any() or np.isfinite(b).any()) else MISSING
    a, b = np.where(seen, a, 0.0), np.where(seen, b, 0.0)
    amplitude = max(float(_size(a).mean()), float(_size(b).mean()), one.floor)
    scale = one.full_scale or amplitude
    lag = _lag(a, b, scale)
    a, b = _shifted(a, b, lag)
    low_a, low_b = _smooth(a), _smooth(b)
    level = float(_size(low_b - low_a).mean()) / scale + abs(float(apart_in_presence))
    noise = abs(_power(b - low_b) - _power(a - low_a)) ** 0.5  # the squares of independent noise add up
    return SignalDifference(100 * level, lag * step_s, 100 * noise / scale)


def _lag(a: FloatArray, b: FloatArray, scale: float) -> int:
    """Return the number of steps that explains most of the difference; 0 if none explains enough."""
    reach = min(_LAGS, len(a) // 4)
    now = float(_size(b - a).mean())
    if now < _SILENT * scale:
        return 0
    left = {lag: float(_size(np.subtract(*_shifted(b, a, -lag))).mean()) for lag in range(-reach, reach + 1)}
    best = min(left, key=lambda lag: (left[lag], abs(lag)))
    return best if left[best] < _EXPLAINS * now else 0


def _shifted(a: FloatArray, b: FloatArray, lag: int) -> tuple[FloatArray, FloatArray]:
    """Return both over the time they have in common if ``b`` is late by ``lag`` steps."""
    if lag == 0:
        return a, b
    return (a[:-lag], b[lag:]) if lag > 0 else (a[-lag:], b[:lag])


def _size(values: FloatArray) -> FloatArray:
    """Return the length of a vector, or the mean of an array, for each step."""
    if values.shape[1] <= 3:
        return np.asarray(np.linalg.norm(values, axis=1), float)
    return np.asarray(np.abs(values).mean(axis=1), float)


def _power(values: FloatArray) -> float:
    """Return the mean square of each number of an array; of a vector, of its length."""
    squares = (values**2).mean(axis=0)
    return float(squares.sum() if len(squares) <= 3 else squares.mean())


def _smooth(values: FloatArray) -> FloatArray:
    """Return the moving mean; shorter at both ends."""
    window = min(_WINDOW, len(values))
    weights = np.convolve(np.ones(len(values)), np.ones(window), "same")
    columns = [np.convolve(column, np.ones(window), "same") / weights for column in values.T]
    return np.array(columns).T
