"""The effect of spikes on leaky integrate-and-fire cells, and populations that none makes fire."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.network.cells import CELLS
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.drawing import extremes
from nrp_core.network.indices import stored_form

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

HIGHEST_CELL_HZ: Final = 1000.0
"""The highest rate of a cell; those with a longer refractory period have a lower one."""
HIGHEST_DEVICE_HZ: Final = 1e5
"""Of one Poisson source or device, which often stands for thousands of neurons."""
MEAN_FACTOR: Final = 2.0
PEAK_FACTOR: Final = 10.0
"""The voltage exceeds its mean by random input: at most so many means and peaks are counted."""


NOT_EXCITED: Final = (
    "no synapse and no device excites it, and its own current does not take it to its threshold"
)


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


def unreached_thresholds(network: Network) -> dict[str, str]:
    """Return a sentence for each population with synapses that cannot reach its threshold.

    A population is not among them if anything about its inputs is unknown: other cells than leaky ones,
    synapses whose weights change or that appear while the network runs, equations.
    """
    inputs: dict[str, list[Projection]] = {label: [] for label in network.populations}
    for projection in network.projections:
        inputs[projection.post].append(projection)
        if projection.is_electrical:
            inputs[projection.pre].append(projection)
    found = {}
    for label, projections in inputs.items():
        cells = network.populations[label]
        distance_mv = distance_to_threshold_mv(cells)
        if distance_mv is None or distance_mv <= 0.0:
            continue
        highest_mv = _highest_voltage_mv(network, cells, projections, distance_mv)
        if highest_mv == 0.0:
            found[label] = NOT_EXCITED
        elif highest_mv is not None and highest_mv < distance_mv:
            found[label] = (
                f"its synapses move a cell by {highest_mv:.2g} mV at most, and its threshold is "
                f"{distance_mv:.3g} mV away; are weights in another unit?"
            )
    return found


def _highest_voltage_mv(
    network: Network, cells: Population, projections: list[Projection], enough_mv: float
) -> float | None:
    """Return a limit of the depolarization of a cell by its synapses, mV; None if unknown or sufficient."""
    total_mv = 0.0
    for projection in projections:
        if projection.neuromodulation is not None:
            continue
        weight = _largest_exciting_weight(projection, cells)
        effect = effect_of_spike(cells, projection.receptor)
        rate_khz = _highest_rate_hz(network.populations[projection.pre]) / 1000.0
        if weight is None or effect is None:
            return None
        each_mv = weight * (MEAN_FACTOR * effect.area_mv_ms * rate_khz + PEAK_FACTOR * effect.peak_mv)
        if total_mv + each_mv >= enough_mv:  # one synapse is enough
            return None
        if each_mv > 0.0:
            total_mv += each_mv * _most_onto_a_cell(projection)
    return total_mv


def _largest_exciting_weight(projection: Projection, cells: Population) -> float | None:
    """Return the largest weight by which a projection excites; 0 if it inhibits, None if it is unknown."""
    if projection.rewiring is not None or projection.equations is not None or projection.is_continuous:
        return None
    if projection.plasticity and "w_max" not in projection.synapse_parameters:
        return None
    if not projection.size:
        return 0.0
    if cells.is_conductance_based:
        reversal = cells.parameters.get("e_rev_E" if projection.receptor == "excitatory" else "e_rev_I")
        if reversal is None or not (reversal > cells.parameters["v_rest"]).any():
            return 0.0
    weight = float(np.max(extremes(stored_form(projection, "weight"))))
    largest = max(weight, float(np.max(projection.synapse_parameters.get("w_max", np.zeros(1)))))
    return None if largest == weight == 0.0 else max(largest, 0.0)  # a function may raise a weight of 0


def _highest_rate_hz(cells: Population) -> float:
    """Return the highest rate at which a cell of a population fires, Hz."""
    if cells.cell_type == "SpikeSourcePoisson":
        return float(np.max(cells.parameters.get("rate", np.array([HIGHEST_DEVICE_HZ]))))
    if cells.cell_type == "SpikeSourceArray":
        intervals_ms = [float(np.diff(times).min()) for times in cells.spike_times_ms if len(times) > 1]
        shortest_ms = min(intervals_ms, default=np.inf)
        return 1000.0 / shortest_ms if shortest_ms > 0.0 else HIGHEST_DEVICE_HZ
    if cells.is_source:
        return HIGHEST_DEVICE_HZ
    refractory_ms = float(np.min(cells.parameters.get("tau_refrac", np.zeros(1)), initial=np.inf))
    return min(HIGHEST_CELL_HZ, 1000.0 / refractory_ms) if refractory_ms > 0.0 else HIGHEST_CELL_HZ


def _most_onto_a_cell(projection: Projection) -> int:
    counts = np.zeros(0, np.int64)
    for _, post in projection.pairs():
        more = np.bincount(post, minlength=len(counts))
        more[: len(counts)] += counts
        counts = more
    return int(counts.max(initial=0))


def too_weak(weight: float, cells: Population) -> str:
    """Return a weight of a device with its effect if at no rate it makes a cell fire; else an empty text."""
    distance_mv = distance_to_threshold_mv(cells)
    effects = [effect_of_spike(cells, receptor) for receptor in ("excitatory", "inhibitory")]
    if not weight or distance_mv is None or distance_mv <= 0.0 or None in effects:
        return ""
    rate_khz = HIGHEST_DEVICE_HZ / 1000.0
    highest_mv = max(weight * one.area_mv_ms * rate_khz for one in effects if one is not None)
    if highest_mv >= distance_mv:
        return ""
    return (
        f"{weight:g}: even {HIGHEST_DEVICE_HZ:.0f} spikes a second move a cell by {highest_mv:.2g} mV, and "
        f"its threshold is {distance_mv:.3g} mV away; is it in another unit?"
    )
