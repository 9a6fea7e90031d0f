"""Convert a network to the arrays of the machine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.hints import hints_of
from nrp_brain_spinnaker.host.cells import Grid, load_cells, tau_syn_of_lines
from nrp_brain_spinnaker.host.rounded_times import rounded_times
from nrp_brain_spinnaker.host.wiring import Wires, longest_ticks, wire
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.rewired_rows import Rewired
from nrp_brain_spinnaker.machine.ring import Ring
from nrp_brain_spinnaker.mapping.fidelity import losses
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_brain_spinnaker.state import Machine
from nrp_brain_spinnaker.synapses.laws import load_stores
from nrp_brain_spinnaker.synapses.layout import Layout
from nrp_brain_spinnaker.synapses.rewired import load_rewired
from nrp_brain_spinnaker.synapses.sites import Site, sites_of
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network, Population
from nrp_core.findings import Findings


@dataclass(frozen=True, slots=True)
class Loaded:
    """A network on the machine.

    Args:
        machine: its arrays.
        grid: the time step.
        wires: the projections on the machine.
        sites: the cores on which synapses form and vanish.
        rewired: these synapses, or None if there are no such cores.
        warnings: warnings about changed values.
    """

    machine: Machine
    grid: Grid
    wires: list[Wires]
    sites: list[Site]
    rewired: Rewired | None
    warnings: Findings


def lay_out(network: Network, options: SpinnakerOptions) -> tuple[Cells, list[Wires], Findings]:
    """Return the cells, the projections with the shifts of their receptors, and warnings.

    These are all properties of a network on the machine that do not need its synapses.

    Raises:
        NetworkError: a parameter, weight or delay does not fit the machine.
    """
    populations = _simulated(network)
    for population in populations:
        hints_of(population, options)
    labels = [population.label for population in populations]
    ids = np.concatenate([np.empty(0, np.int64), *(network.ids_of(label) for label in labels)])
    cells = load_cells(populations, ids, Grid(options.step_us, options.substeps), options.semantics)
    wires, warnings = wire(network, labels, cells, options)
    for part in wires:
        cells.populations[part.population, kinds.SHIFT_EXC + part.receptor] = part.shift
    warnings += losses(wires, options)
    warnings += rounded_times(network, options)
    return cells, wires, warnings


def load(network: Network, options: SpinnakerOptions) -> Loaded:
    """Load a network onto the machine.

    Raises:
        NetworkError: a parameter, weight or delay does not fit the machine.
        CapabilityError: the machine does not have a plasticity rule.
    """
    grid = Grid(options.step_us, options.substeps)
    cells, wires, warnings = lay_out(network, options)
    populations, n = _simulated(network), cells.ids.size
    tau_syn = tau_syn_of_lines(populations, options.semantics)
    layout = Layout(network, options, n, tau_syn, grid)
    sites = sites_of(wires, layout)
    machine = Machine(
        cells=cells,
        ring=_ring(n, longest_ticks(wires)),
        stores=load_stores(wires, layout),
    )
    rewired = load_rewired(wires, sites, layout) if sites else None
    return Loaded(machine, grid, wires, sites, rewired, warnings)


def _simulated(network: Network) -> list[Population]:
    return [population for population in network.populations.values() if not population.is_source]


def _ring(n: int, longest: int) -> Ring:
    """Return an empty ring for the longest delay in ticks."""
    slots = 1 << max(1, (longest - 1).bit_length())
    lines: IntArray = np.zeros((2, 2 * n), np.int64)
    return Ring(np.zeros((slots, 2 * n), np.uint16), device=lines[0], saturated=lines[1])
