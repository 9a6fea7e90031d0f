"""Populations that nothing excites, or whose synapses are too weak, however often their sources fire."""

from __future__ import annotations

from typing import Final

import numpy as np

from nrp_core.brain.network.data import Network, Population, Projection
from nrp_core.brain.network.drawing import extremes
from nrp_core.brain.network.indices import stored_form
from nrp_core.checks.synaptic_effects import distance_to_threshold_mv, effect_of_spike

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


def unreached_thresholds(network: Network) -> dict[str, str]:
    """Return a sentence for each population that its synapses cannot take to its threshold, if it has any.

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
    """Return a limit of the depolarization of a cell by its synapses, mV; None if it is unknown or enough."""
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
