"""From a network to the arrays of the machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.cells import Grid, load_cells, tau_syn_of_lines
from nrp_brain_spinnaker.host.plastic_rows import load_plastic
from nrp_brain_spinnaker.host.rows import load_dynamic, load_static
from nrp_brain_spinnaker.host.wiring import Wires, longest_ticks, wire
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.ring import Ring
from nrp_brain_spinnaker.machine.state import Machine
from nrp_brain_spinnaker.mapping.fidelity import losses
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network, Population
from nrp_core.brain.network.synapses.static import STATIC
from nrp_core.brain.network.synapses.stdp import STDP
from nrp_core.brain.network.synapses.tsodyks_markram import TSODYKS_MARKRAM


@dataclass(frozen=True, slots=True)
class Loaded:
    """A network on the machine.

    Args:
        machine: its arrays.
        grid: the time step.
        wires: the projections as the machine has them.
        warnings: what was not taken over as given.
    """

    machine: Machine
    grid: Grid
    wires: list[Wires]
    warnings: list[str]


def lay_out(network: Network, options: SpinnakerOptions) -> tuple[Cells, list[Wires], list[str]]:
    """Return the cells, the projections with the shifts of their receptors, and warnings.

    That is all that can be known of a network on the machine without expanding its synapses.

    Raises:
        NetworkError: a parameter, weight or delay does not fit the machine.
    """
    populations = _simulated(network)
    labels = [population.label for population in populations]
    ids = np.concatenate([np.empty(0, np.int64), *(network.ids_of(label) for label in labels)])
    cells = load_cells(populations, ids, Grid(options.step_us, options.substeps), options.semantics)
    wires, warnings = wire(network, labels, cells, options)
    for part in wires:
        cells.populations[part.population, kinds.SHIFT_EXC + part.receptor] = part.shift
    return cells, wires, [*warnings, *losses(wires, options)]


def load(network: Network, options: SpinnakerOptions) -> Loaded:
    """Put a network on the machine.

    Raises:
        NetworkError: a parameter, weight or delay does not fit the machine.
        CapabilityError: a plasticity rule that it does not have.
    """
    grid = Grid(options.step_us, options.substeps)
    cells, wires, warnings = lay_out(network, options)
    populations, n = _simulated(network), cells.ids.size
    static, dynamic, plastic = (_of_type(wires, kind) for kind in (STATIC, TSODYKS_MARKRAM, STDP))
    machine = Machine(
        cells=cells,
        ring=_ring(n, longest_ticks(wires)),
        static=load_static(static, network.size, n),
        dynamic=load_dynamic(dynamic, network.size, tau_syn_of_lines(populations, options.semantics), grid),
        plastic=load_plastic(plastic, network.size, n, grid.step_us, options.semantics),
    )
    return Loaded(machine, grid, wires, warnings)


def _simulated(network: Network) -> list[Population]:
    return [population for population in network.populations.values() if not population.is_source]


def _of_type(wires: Sequence[Wires], synapse_type: str) -> list[Wires]:
    return [part for part in wires if part.projection.synapse_type == synapse_type]


def _ring(n: int, longest: int) -> Ring:
    """Return an empty ring that reaches as far as the longest delay in ticks."""
    slots = 1 << max(1, (longest - 1).bit_length())
    lines: IntArray = np.zeros((2, 2 * n), np.int64)
    return Ring(np.zeros((slots, 2 * n), np.uint16), device=lines[0], saturated=lines[1])
