"""Distances between curves and between spike trains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import jit


def dtw_distance(one: FloatArray, other: FloatArray, band: float = 0.2) -> float:
    """Return the mean distance along the best alignment of two curves in time (dynamic time warping).

    Sakoe and Chiba 1978, IEEE Trans. ASSP 26:43, with their symmetric steps and their band.

    Args:
        one: points, shape ``(n, dimensions)``.
        other: the same; the number of points may differ.
        band: largest difference in time, as a share of the length.
    """
    reach = max(int(band * max(len(one), len(other))), abs(len(one) - len(other)), 1)
    return float(_dtw(one, other, reach)) / (len(one) + len(other))


@jit
def _dtw(one: FloatArray, other: FloatArray, reach: int) -> float:
    """Return the smallest sum of distances along a path; a diagonal step counts twice."""
    n, m, dimensions = one.shape[0], other.shape[0], one.shape[1]
    before, row = np.full(m + 1, np.inf), np.full(m + 1, np.inf)
    before[0] = 0.0
    for i in range(n):
        row[:] = np.inf
        for j in range(max(0, i - reach), min(m, i + reach + 1)):
            squares = 0.0
            for k in range(dimensions):
                squares += (one[i, k] - other[j, k]) ** 2
            d = np.sqrt(squares)
            row[j + 1] = min(before[j + 1] + d, row[j] + d, before[j] + 2 * d)
        before, row = row, before
    return float(before[m])


def filtered_trains(
    trains_s: Sequence[FloatArray], end_s: float, tau_s: float, step_s: float = 0.005
) -> FloatArray:
    """Return spike trains as curves whose distance is van Rossum's.

    Every spike is followed by an exponential decay; van Rossum 2001, Neural Comput. 13:751.

    Args:
        trains_s: spike times of each neuron, s.
        end_s: end of the curves, s.
        tau_s: time constant of the decay, s; much smaller shifts have no effect on the distance.
        step_s: sampling interval of the curves, s.

    Returns:
        shape ``(n_trains, n_samples)``, scaled so that a single spike has a norm of 1.
    """
    samples = int(np.ceil(end_s / step_s)) + 1
    curves = np.zeros((len(trains_s), samples))
    for curve, train in zip(curves, trains_s, strict=True):
        index = np.minimum(np.ceil(train / step_s).astype(int), samples - 1)
        np.add.at(curve, index, np.exp(-(index * step_s - train) / tau_s))
    from scipy.signal import lfilter

    decay = float(np.exp(-step_s / tau_s))
    filtered: FloatArray = lfilter([1.0], [1.0, -decay], curves, axis=1)
    filtered *= np.sqrt(2 * step_s / tau_s)
    return filtered
