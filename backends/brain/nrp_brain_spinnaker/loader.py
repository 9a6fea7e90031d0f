"""Convert a network to the arrays of the machine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.hints import hints_of
from nrp_brain_spinnaker.host.cells import Grid, load_cells, tau_syn_of_lines
from nrp_brain_spinnaker.host.wiring import Wires, longest_ticks, wire
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.ring import Ring
from nrp_brain_spinnaker.mapping.fidelity import losses
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_brain_spinnaker.state import Machine
from nrp_brain_spinnaker.synapses.laws import load_stores
from nrp_brain_spinnaker.synapses.layout import Layout
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
        warnings: warnings about changed values.
    """

    machine: Machine
    grid: Grid
    wires: list[Wires]
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
    layout = Layout(network.size, n, tau_syn, grid, options.semantics)
    machine = Machine(
        cells=cells,
        ring=_ring(n, longest_ticks(wires)),
        stores=load_stores(wires, layout),
    )
    return Loaded(machine, grid, wires, warnings)


def _simulated(network: Network) -> list[Population]:
    return [population for population in network.populations.values() if not population.is_source]


def _ring(n: int, longest: int) -> Ring:
    """Return an empty ring for the longest delay in ticks."""
    slots = 1 << max(1, (longest - 1).bit_length())
    lines: IntArray = np.zeros((2, 2 * n), np.int64)
    return Ring(np.zeros((slots, 2 * n), np.uint16), device=lines[0], saturated=lines[1])
