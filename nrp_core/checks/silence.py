"""The parts of a network without spikes: silent sources and cells, and projections that transmit none."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Final, NamedTuple

import numpy as np

from nrp_core.brain.network.data import Network, Population, Projection


class Silence(NamedTuple):
    """A part without spikes at first.

    Args:
        part: the part in words.
        first_ms: the time before which it has no effect; None if it never has one.
        is_rare: whether that is the mean time to its first spike.
    """

    part: str
    first_ms: float | None
    is_rare: bool = False


_LEAKY: Final = frozenset({"IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp", "IF_cond_alpha"})
"""Cells that fire when their voltage reaches ``v_thresh``, and that nothing but input takes there."""


def silent_parts(network: Network) -> list[Silence]:
    """Return the times of the first spikes of sources and projections, if they are after 0 ms."""
    return [*_sources(network), *_projections(network)]


def _sources(network: Network) -> Iterator[Silence]:
    for label, population in network.populations.items():
        first_ms = _first_ms(population)
        if first_ms > 0:
            yield Silence(f"the source '{label}' does not fire", None if first_ms == inf else first_ms)
        elif population.cell_type == "SpikeSourcePoisson" and "rate" in population.parameters:
            rate_hz = float(np.sum(population.parameters["rate"]))
            yield Silence(f"the source '{label}' has hardly a spike", 1000.0 / rate_hz, is_rare=True)


def mute(network: Network) -> list[str]:
    """Return the labels of the populations of which no cell can fire unless a device drives it.

    They have no synapse that excites, and their resting potential with their constant current, ``v_rest +
    i_offset tau_m / cm``, is below the threshold, as their initial voltage is.
    """
    excited = {one.post for one in network.projections if _may_excite(one, network.populations[one.post])}
    return [label for label, one in network.populations.items() if label not in excited and _rests_below(one)]


def _may_excite(projection: Projection, post: Population) -> bool:
    if projection.neuromodulation is not None:
        return False
    if projection.rewiring is not None or projection.plasticity:
        return True
    if post.is_conductance_based and projection.receptor == "inhibitory":
        cells = post.parameters
        return bool(projection.size and (cells["e_rev_I"] >= cells["v_thresh"]).any())
    return bool(np.any(projection.weight >= 0))  # a function may raise a weight of 0


def _rests_below(population: Population) -> bool:
    cells = population.parameters
    if population.cell_type not in _LEAKY or not cells or not population.size:
        return False
    rest_mv = cells["v_rest"] + np.maximum(cells["i_offset"], 0.0) * cells["tau_m"] / cells["cm"]
    begins_mv = population.initial_values.get("v", cells["v_rest"])
    return bool((np.maximum(rest_mv, begins_mv) < cells["v_thresh"]).all())


def _first_ms(population: Population) -> float:
    """Return the earliest time at which a source can fire, 0 for cells that are not sources."""
    if population.cell_type == "SpikeSourceArray":
        return min((float(train[0]) for train in population.spike_times_ms if len(train)), default=inf)
    if population.is_source and "duration" in population.parameters:
        rates = np.asarray(population.parameters.get("rate", population.parameters.get("beta", 1.0)))
        starts_ms, lasts_ms = (np.asarray(population.parameters[name]) for name in ("start", "duration"))
        fires = (lasts_ms > 0) & (starts_ms + lasts_ms > 0) & (rates > 0)
        return float(np.min(np.maximum(starts_ms[fires], 0.0), initial=inf))
    return 0.0


def _projections(network: Network) -> Iterator[Silence]:
    for projection in network.projections:
        name = f"the projection '{projection.label}'"
        if projection.rewiring is not None:
            yield Silence(f"{name} transmits no spikes", projection.rewiring.initial_delay_low)
        elif not projection.size:
            yield Silence(f"{name} has no synapses, so it transmits no spikes", None)
        elif _is_weightless(projection):
            yield Silence(f"{name} has no effect: all its weights are 0", None)
        else:
            yield Silence(f"{name} transmits no spikes", float(np.min(projection.delay_ms)))


def _is_weightless(projection: Projection) -> bool:
    return not (projection.plasticity or np.any(projection.weight))
