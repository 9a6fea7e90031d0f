"""Gates of Hodgkin-Huxley cells at rest (Traub & Miles 1991, Neuronal Networks of the Hippocampus)."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray


def settled_gates(v_mv: FloatArray) -> dict[str, FloatArray]:
    """Return the steady states of the gates m, h and n, by PyNN name.

    Args:
        v_mv: voltages above the model's offset, shape ``(n,)``.
    """
    rates = {
        "m": (0.32 * _over_exponential(13.0 - v_mv, 4.0), 0.28 * _over_exponential(v_mv - 40.0, 5.0)),
        "h": (0.128 * np.exp((17.0 - v_mv) / 18.0), 4.0 / (np.exp((40.0 - v_mv) / 5.0) + 1.0)),
        "n": (0.032 * _over_exponential(15.0 - v_mv, 5.0), 0.5 * np.exp((10.0 - v_mv) / 40.0)),
    }
    return {gate: opening / (opening + closing) for gate, (opening, closing) in rates.items()}


def _over_exponential(x: FloatArray, scale: float) -> FloatArray:
    """Return ``x / (exp(x / scale) - 1)`` and its limit at 0."""
    safe = np.where(x == 0.0, 1.0, x)
    return np.where(x == 0.0, scale, safe / np.expm1(safe / scale))
