"""The cortical microcircuit of Potjans and Diesmann: its numbers, its scaling, and statistics of its spikes.

Potjans and Diesmann (2014), Cereb. Cortex 24:785; Poisson input. Scaled networks keep mean and variance of
the input of each cell: van Albada, Helias and Diesmann (2015), PLoS Comput. Biol. 11:e1004490.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LABELS = ("L23E", "L23I", "L4E", "L4I", "L5E", "L5I", "L6E", "L6I")
SIZES = np.array([20683, 5834, 21915, 5479, 4850, 1065, 14395, 2948])
PROBABILITIES = np.array(
    [
        [0.1009, 0.1689, 0.0437, 0.0818, 0.0323, 0.0, 0.0076, 0.0],
        [0.1346, 0.1371, 0.0316, 0.0515, 0.0755, 0.0, 0.0042, 0.0],
        [0.0077, 0.0059, 0.0497, 0.135, 0.0067, 0.0003, 0.0453, 0.0],
        [0.0691, 0.0029, 0.0794, 0.1597, 0.0033, 0.0, 0.1057, 0.0],
        [0.1004, 0.0622, 0.0505, 0.0057, 0.0831, 0.3726, 0.0204, 0.0],
        [0.0548, 0.0269, 0.0257, 0.0022, 0.06, 0.3158, 0.0086, 0.0],
        [0.0156, 0.0066, 0.0211, 0.0166, 0.0572, 0.0197, 0.0396, 0.2252],
        [0.0364, 0.001, 0.0034, 0.0005, 0.0277, 0.008, 0.0658, 0.1443],
    ]
)
"""That two cells are connected at least once: row target, column source."""
INPUTS = np.array([1600, 1500, 2100, 1900, 2000, 1900, 2900, 2100])
INPUT_HZ, WEIGHT_NA, INHIBITION, SPREAD = 8.0, 0.0878, -4.0, 0.1
DELAY_MS, DELAY_SPREAD = {"E": 1.5, "I": 0.75}, 0.5
START_MV = -58.0, 5.0
STEP_MS = 0.1
CELL = {
    "cm": 0.25, "tau_m": 10.0, "tau_refrac": 2.0, "tau_syn_E": 0.5, "tau_syn_I": 0.5,
    "v_rest": -65.0, "v_reset": -65.0, "v_thresh": -50.0,
}  # fmt: skip
RATES_HZ = np.array([0.971, 2.868, 4.746, 5.396, 8.142, 9.078, 0.991, 7.523])
"""Rates of the whole network by PyNN's example ``Potjans2014``, by which smaller ones are compensated."""
PUBLISHED = {
    1.0: {
        "rate_hz": [0.90, 2.80, 4.39, 5.70, 6.80, 8.22, 1.14, 7.60],
        "cv": [0.938, 0.916, 0.891, 0.873, 0.847, 0.809, 0.924, 0.819],
        "synchrony": [2.9, 1.8, 3.0, 1.7, 4.4, 1.1, 1.2, 1.0],
    },
    0.1: {
        "rate_hz": [0.75, 3.28, 4.76, 6.20, 6.55, 8.97, 1.10, 8.06],
        "cv": [0.937, 0.919, 0.883, 0.869, 0.853, 0.800, 0.938, 0.810],
        "synchrony": [2.6, 2.1, 3.1, 1.9, 4.5, 1.1, 1.7, 1.0],
    },
    0.02: {
        "rate_hz": [0.69, 3.8, 4.15, 5.90, 7.08, 8.70, 1.02, 7.96],
        "cv": [0.935, 0.895, 0.891, 0.863, 0.837, 0.811, 0.932, 0.817],
        "synchrony": [2.5, 1.9, 2.7, 1.8, 2.4, 1.1, 1.4, 1.0],
    },
}
"""In NEURON, by scale, 60 s: Romaro et al. (2021), Neural Comput. 33:1993, tables A.1, A.3 and A.5."""
OBSERVED, BIN_MS = 1000, 3.0
"""The cells of each population that are observed, and the bins in which synchrony counts their spikes."""


def sizes(scale: float) -> npt.NDArray[np.int64]:
    """Return the number of cells of each population."""
    return np.rint(SIZES * scale).astype(np.int64)


def synapses(scale: float) -> npt.NDArray[np.int64]:
    """Return the number of synapses between populations, row target, column source."""
    pairs = np.outer(SIZES, SIZES).astype(float)
    whole = np.rint(np.log1p(-PROBABILITIES) / np.log1p(-1.0 / pairs))
    scaled: npt.NDArray[np.int64] = np.rint(whole / SIZES[:, None] * scale * sizes(scale)[:, None]).astype(
        int
    )
    return scaled


def weights_na(scale: float) -> Floats:
    """Return the mean weights, row target, column source."""
    full = np.where(np.arange(8) % 2, INHIBITION * WEIGHT_NA, WEIGHT_NA) * np.ones((8, 1))
    full[0, 2] *= 2.0  # from layer 4 to layer 2/3
    scaled: Floats = full / np.sqrt(scale)
    return scaled


def spread(target: int, source: int) -> float:
    """Return the standard deviation of weights as a share of their mean."""
    return SPREAD / 2.0 if (target, source) == (0, 2) else SPREAD


def input_hz(scale: float) -> Floats:
    """Return the rate of the Poisson input of a cell of each population."""
    return INPUTS * scale * INPUT_HZ


def constant_na(scale: float) -> Floats:
    """Return the constant current that replaces the mean of the inputs that a smaller network lacks."""
    full = synapses(1.0) / SIZES[:, None] * weights_na(1.0) @ RATES_HZ + INPUTS * WEIGHT_NA * INPUT_HZ
    current: Floats = 1e-3 * CELL["tau_syn_E"] * (1.0 - np.sqrt(scale)) * full
    return current


def statistics(trains: list[Floats], start_ms: float, stop_ms: float) -> dict[str, float]:
    """Return rate, mean CV of intervals, and synchrony of cells: variance over mean of their spike counts."""
    trains = [train[train >= start_ms] for train in trains]
    together = np.concatenate(trains)
    intervals = [np.diff(train) for train in trains if len(train) > 3]
    counts, _ = np.histogram(together, np.arange(start_ms, stop_ms + BIN_MS / 2, BIN_MS))
    return {
        "rate_hz": len(together) / len(trains) / (stop_ms - start_ms) * 1e3,
        "cv": float(np.mean([each.std(ddof=1) / each.mean() for each in intervals])) if intervals else 0.0,
        "synchrony": float(counts.var() / max(counts.mean(), 1e-9)),
    }


def table(found: dict[str, dict[str, float]], scale: float) -> str:
    """Return the statistics of all populations beside the published ones of the nearest scale, as text."""
    published = PUBLISHED[min(PUBLISHED, key=lambda known: abs(np.log(known / scale)))]
    lines = [f"{'':6s}" + "".join(f"{name:>11s}{'published':>11s}" for name in published)]
    for k, (label, own) in enumerate(found.items()):
        cells = "".join(f"{own[name]:11.3f}{values[k]:11.3f}" for name, values in published.items())
        lines.append(f"{label:6s}{cells}")
    return "\n".join(lines)
