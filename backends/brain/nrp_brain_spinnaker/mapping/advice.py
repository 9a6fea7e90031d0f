"""Advice on the parts of a network that would not fit a machine or not keep up."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np

from nrp_brain_spinnaker import hardware
from nrp_brain_spinnaker.mapping.machine_map import VertexMap


def advise(maps: Sequence[VertexMap], chips: int, entries: int, packets_per_s: float) -> tuple[str, ...]:
    """Return a sentence for each problem.

    Args:
        maps: all vertices.
        chips: number of used chips.
        entries: number of routing entries of the fullest chip.
        packets_per_s: packets of the whole network, 1/s.
    """
    advice = [line for vertex in maps for line in _on_vertex(vertex)]
    if chips > hardware.LARGEST_MACHINE_CHIPS:
        advice.append(f"{chips} chips: the largest machine has {hardware.LARGEST_MACHINE_CHIPS}")
    if entries > hardware.ROUTER_ENTRIES:
        advice.append(f"{entries} routing entries: a chip has {hardware.ROUTER_ENTRIES}; merge populations")
    if packets_per_s > hardware.LINK_PACKETS_PER_S:
        advice.append(f"{packets_per_s:.3g} packets/s: a link carries {hardware.LINK_PACKETS_PER_S:.0g}")
    sdram = np.bincount(
        [core.chip for vertex in maps for core in vertex.cores],
        weights=[vertex.sdram_bytes for vertex in maps for _ in vertex.cores],
    )
    if sdram.size and sdram.max() > hardware.SDRAM_BYTES:
        needed, has = (n >> 20 for n in (int(sdram.max()), hardware.SDRAM_BYTES))
        advice.append(f"{needed} MB of SDRAM on one chip: it has {has}; use fewer neurons_per_core")
    return tuple(advice)


def _on_vertex(vertex: VertexMap) -> list[str]:
    where, row, queue = f"population '{vertex.label}'", hardware.LONGEST_ROW, hardware.QUEUED_SPIKES
    advice = []
    if vertex.left_shifts and vertex.cell_type not in hardware.UPDATE_INSTRUCTIONS:
        advice.append(f"{where}: sPyNNaker has no {vertex.cell_type} cells; the load is a rough estimate")
    if vertex.longest_row > row:
        advice.append(f"{where}: {vertex.longest_row} synapses from one neuron; a row holds {row}")
    if vertex.synapse_cores > hardware.SYNAPSE_CORES:
        advice.append(
            f"{where}: {vertex.synapse_cores} cores for the synapses of each core of neurons; a chip has "
            f"{hardware.SYNAPSE_CORES}; use fewer neurons_per_core or a time step of 1 ms"
        )
    if vertex.dtcm_bytes > hardware.DTCM_BYTES:
        advice.append(f"{where}: a core's own memory is too small; use fewer neurons_per_core")
    if vertex.spikes_per_step > queue:
        advice.append(
            f"{where}: {vertex.spikes_per_step:.0f} spikes in a time step; a core can queue {queue}"
        )
    if vertex.utilisation > hardware.BUSY:
        slower = ceil(vertex.utilisation / hardware.BUSY)
        advice.append(
            f"{where}: a core is busy for {vertex.utilisation:.0%} of a time step; run {slower} times slower "
            "(time_scale_factor) or use fewer neurons_per_core"
        )
    return advice
