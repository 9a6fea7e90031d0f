"""What one spike does to the voltage of a leaky integrate-and-fire cell at rest."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.cells import CELLS
from nrp_core.brain.network.data import Population

LEAKY_CELLS: Final = frozenset({
    "IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp", "IF_cond_alpha",
})  # fmt: skip
"""Cells that fire when their voltage reaches ``v_thresh``, and that only currents take there."""
_IN_MV: Final = frozenset(cell.name for cell in CELLS.values() if cell.weight_unit == "mV")
_DISTINCT_CELLS: Final = 1000
"""Cells with different parameters for which a course is computed; of more, every k-th."""
_TIMES: Final = np.geomspace(1e-3, 20.0, 512)
"""Times after a spike, in time constants, among which the peak is searched."""
_EQUAL: Final = 1e-4
"""Time constants that differ by less are taken apart by this share; their difference is a divisor."""
NEVER_MV: Final = 1e5
"""A threshold from which cells never fire, as scripts write it (1e6, 1e10 mV); in uV it is at most this."""


class SynapticEffect(NamedTuple):
    """The largest effect of one spike on a cell of a population, for a weight of 1.

    A conductance acts with its driving force at rest, so strong ones have less effect than this.

    Args:
        peak_mv: the peak of the postsynaptic potential, mV.
        area_mv_ms: its integral: times a rate in kHz it is the mean depolarization, mV.
    """

    peak_mv: float
    area_mv_ms: float


def effect_of_spike(cells: Population, receptor: str) -> SynapticEffect | None:
    """Return the effect of a spike at a receptor of leaky cells; None if it is unknown.

    With the synaptic current ``I(t) = w exp(-t / tau_syn)``, or ``w (t / tau_syn) exp(1 - t / tau_syn)`` for
    cells with alpha functions, the potential is ``1 / cm`` times the convolution of ``I`` with
    ``exp(-t / tau_m)`` (Rotter and Diesmann, Biological Cybernetics 81:381, 1999).
    """
    known, size = cells.parameters, cells.size
    if cells.cell_type not in LEAKY_CELLS or not size or not {"tau_m", "cm"} <= known.keys():
        return None
    if cells.cell_type in _IN_MV:
        return SynapticEffect(1.0, float(known["tau_m"].max()))
    letter = {"excitatory": "E", "inhibitory": "I"}.get(receptor)
    reversal = (f"e_rev_{letter}", "v_rest") if cells.is_conductance_based else ()
    needed = ("cm", "tau_m", f"tau_syn_{letter}", *reversal)
    if letter is None or not set(needed) <= known.keys():
        return None
    rows = np.unique(np.stack([np.broadcast_to(known[name], size) for name in needed]), axis=1)
    rows = rows[:, :: 1 + rows.shape[1] // _DISTINCT_CELLS]
    cm_nf, tau_m_ms, tau_syn_ms = rows[:3]
    force = np.abs(rows[3] - rows[4]) if reversal else np.ones(rows.shape[1])
    is_alpha = cells.cell_type.endswith("alpha")
    peaks = force / cm_nf * _peaks(tau_m_ms, tau_syn_ms, is_alpha=is_alpha)
    charge = tau_syn_ms * (np.e if is_alpha else 1.0)
    return SynapticEffect(float(peaks.max()), float((force / cm_nf * charge * tau_m_ms).max()))


def _peaks(tau_m_ms: FloatArray, tau_syn_ms: FloatArray, *, is_alpha: bool) -> FloatArray:
    """Return the peaks of the convolutions of unit currents with ``exp(-t / tau_m)``, ms."""
    near = np.abs(tau_syn_ms / tau_m_ms - 1.0) < _EQUAL
    tau_syn_ms = np.where(near, tau_m_ms * (1.0 + _EQUAL), tau_syn_ms)
    apart = 1.0 / tau_syn_ms - 1.0 / tau_m_ms
    if not is_alpha:  # where the derivative is 0
        times_ms = np.log(tau_m_ms / tau_syn_ms) / apart
        peaks: FloatArray = (np.exp(-times_ms / tau_m_ms) - np.exp(-times_ms / tau_syn_ms)) / apart
        return peaks
    times = _TIMES[:, None] * (tau_m_ms + tau_syn_ms)
    courses = np.exp(-times / tau_m_ms) - np.exp(-times / tau_syn_ms) * (1.0 + apart * times)
    found: FloatArray = np.max(courses * np.e / (tau_syn_ms * apart**2), axis=0)
    return found


def distance_to_threshold_mv(cells: Population) -> float | None:
    """Return how far the nearest leaky cell rests below its threshold, mV; None if unknown or endless.

    Its constant current counts. Cells that fire without input have a distance of 0 or less.
    """
    known = cells.parameters
    if cells.cell_type not in LEAKY_CELLS or not {"v_rest", "v_thresh", "tau_m", "cm"} <= known.keys():
        return None
    current_na = np.maximum(known.get("i_offset", np.zeros(1)), 0.0)
    distances_mv = known["v_thresh"] - known["v_rest"] - current_na * known["tau_m"] / known["cm"]
    begins_mv = cells.initial_values.get("v")
    if begins_mv is not None and (begins_mv >= known["v_thresh"]).any():
        return 0.0
    distance_mv = float(np.min(distances_mv, initial=np.inf))
    return distance_mv if distance_mv < NEVER_MV else None
