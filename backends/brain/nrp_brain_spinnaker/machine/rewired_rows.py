"""The rows of synapses that form and vanish, and how spikes pass through them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy.typing as npt

from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.stdp import deliver_row, remember
from nrp_brain_spinnaker.machine.stdp_rows import StdpRows, changing_rows
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring, WeightArray
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core._support.jit import jit


class Sites(NamedTuple):
    """Synapses that form and vanish; :mod:`~nrp_brain_spinnaker.machine.rewiring` changes them.

    A *site* is a core with the synapses onto a slice of a population, a *group* a projection at a site.

    Args:
        length: number of synapses of each row.
        row_of: the row of each source cell of each group, group after group.
        n_neurons: number of simulated neurons.
        settings: of each site, shape ``(n, SITE_COLUMNS)``.
        groups: their settings, shape ``(n, GROUP_COLUMNS)``.
        part_first, part_size: first source cell and number of source cells on each source core.
        probability: the probabilities of forming by squared distance, of 65535.
        place_group, place_source: the synapse at each place of each target cell; source -1 for none.
        waited: ticks since the last attempt of each site.
        shared, local: random numbers of each site: the same for all sites of a population, and its own.
        choice: the current attempt and the next, shape ``(2, CHOICE_COLUMNS)``.
        copy_count, copy_line, copy_weight, copy_delay: their rows.
        heard_start, heard_site, heard_as: the sites that receive spikes of each global id, and its group or
            -1.
        first_of: the first global id of each group's source population.
        heard_at, n_heard: the last tick with a spike at each site; number of spikes in even and odd ticks.
        heard_group, heard_source: these spikes, shape ``(n_sites, 2, spikes)``.
        attempts: the largest number of attempts in a tick.
        changes: tick, group, source cell, target cell, and 1 for a new synapse or 0 for one that vanished.
        n_changes: the number of those.
    """

    length: IntArray
    row_of: IntArray
    n_neurons: int
    settings: IntArray
    groups: IntArray
    part_first: IntArray
    part_size: IntArray
    probability: IntArray
    place_group: IntArray
    place_source: IntArray
    waited: IntArray
    shared: IntArray
    local: IntArray
    choice: IntArray
    copy_count: IntArray
    copy_line: IndexArray
    copy_weight: WeightArray
    copy_delay: WeightArray
    heard_start: IntArray
    heard_site: IntArray
    heard_as: IntArray
    first_of: IntArray
    heard_at: IntArray
    n_heard: IntArray
    heard_group: IntArray
    heard_source: IntArray
    attempts: int
    changes: IntArray
    n_changes: IntArray


class Rewired(NamedTuple):
    """Synapses that form and vanish: their rows, each with room for all that it may have, and their sites.

    They are two functions, because calls with many arrays take long to compile.
    """

    rows: StdpRows
    sites: Sites


def changing_rewired(rewired: Rewired) -> list[npt.NDArray[Any]]:
    """Return the arrays that running changes."""
    rows, sites = rewired
    return [
        *changing_rows(rows), rows.line, rows.delay, sites.length, sites.place_group, sites.place_source,
        sites.waited, sites.shared, sites.local, sites.heard_at, sites.n_heard, sites.heard_group,
        sites.heard_source,
    ]  # fmt: skip


@jit
def has_room(rewired: Rewired) -> bool:
    """Return whether all changes of another tick can be noted."""
    sites = rewired.sites
    return bool(sites.n_changes[0] + sites.attempts <= sites.changes.shape[1])


@jit
def deliver_rewired(rewired: Rewired, ring: Ring, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) in ``tick`` through its synapses that form and vanish."""
    rows, sites = rewired
    for row in range(rows.start[neuron], rows.start[neuron + 1]):
        deliver_row(rows, None, ring, row, rows.first[row] + sites.length[row], tick)
    for k in range(sites.heard_start[neuron], sites.heard_start[neuron + 1]):
        _hear(sites, sites.heard_site[k], sites.heard_as[k], neuron, tick)


@jit
def _hear(sites: Sites, site: int, group: int, neuron: int, tick: int) -> None:
    """Remember a spike at a site, as a possible source of a new synapse."""
    parity = tick & 1
    if tick != sites.heard_at[site]:
        sites.heard_at[site], sites.n_heard[site, parity] = tick, 0
    n = sites.n_heard[site, parity]
    if n < sites.heard_group.shape[2]:
        sites.heard_group[site, parity, n] = group
        sites.heard_source[site, parity, n] = neuron - sites.first_of[group] if group >= 0 else -1
        sites.n_heard[site, parity] = n + 1


@jit
def emit_rewired(rewired: Rewired, cells: Cells, ring: Ring, tick: int) -> None:
    """Send the spikes of all neurons that fired in ``tick`` through their synapses that form and vanish."""
    n_fired = cells.n_fired[0]
    for k in range(n_fired):
        remember(rewired.rows, cells.fired[k], tick)
    for k in range(n_fired):
        deliver_rewired(rewired, ring, cells.ids[cells.fired[k]], tick)
