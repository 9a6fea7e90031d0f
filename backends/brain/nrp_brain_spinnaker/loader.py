"""Convert a network to the arrays of the machine.

Times of a network that the machine moves to whole steps, and steps that it cannot keep up with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.engine import Machine
from nrp_brain_spinnaker.host.cells import Grid, Layout, load_cells, tau_syn_of_lines
from nrp_brain_spinnaker.host.wiring import Wires, longest_ticks, wire
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.rewired_rows import Rewired
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring
from nrp_brain_spinnaker.mapping.fidelity import losses
from nrp_brain_spinnaker.options import SpinnakerOptions, hinted_substeps, hints_of
from nrp_brain_spinnaker.synapses.laws import load_stores
from nrp_brain_spinnaker.synapses.rewired import load_rewired
from nrp_brain_spinnaker.synapses.sites import Site, sites_of
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.findings import Code, Findings
from nrp_core.network.data import Network, Population

_SHORTEST_STEP_US = 100
"""Below it sPyNNaker warns that a machine does not keep up, unless it is slowed down."""
_ROUNDING = 1e-6


def rounded_times(network: Network, options: SpinnakerOptions) -> Findings:
    """Return warnings about a very short step, and about spikes and refractory periods between two steps."""
    step_ms, warnings = options.step_us / 1000, Findings()
    if options.step_us < _SHORTEST_STEP_US:
        warnings.add(
            Code.NRP217,
            f"a time step of {step_ms:g} ms is below 0.1 ms, the shortest that a machine keeps up with; a "
            "real one needs a time_scale_factor",
        )
    between = list(_spikes(network, step_ms))
    if between:
        warnings.add(
            Code.NRP217, f"spikes between time steps of {step_ms:g} ms come at the next: {_listed(between)}"
        )
    rounded = list(_refractory(network, options))
    if rounded:
        warnings.add(Code.NRP217, f"refractory periods become whole time steps: {_listed(rounded)}")
    return warnings


def _listed(moved: Sequence[tuple[str, float, float]]) -> str:
    names = ", ".join(f"'{label}' ({old_ms:g} -> {new_ms:g} ms)" for label, old_ms, new_ms in moved[:3])
    return names + (f" and {len(moved) - 3} more" if len(moved) > 3 else "")


def _spikes(network: Network, step_ms: float) -> Iterator[tuple[str, float, float]]:
    """Yield the first spike time of each population that is between two steps, ms, before and after."""
    for population in network.populations.values():
        times = [np.asarray(one, float) for one in population.spike_times_ms if len(one)]
        if times:
            yield from _first_between(population.label, np.concatenate(times), step_ms)


def _refractory(network: Network, options: SpinnakerOptions) -> Iterator[tuple[str, float, float]]:
    """Yield the first refractory period of each population that is not a number of steps, before and after.

    Periods of less than a step, such as PyNN's default, mean none.
    """
    for population in network.populations.values():
        step_ms = options.step_us / 1000 / max(options.substeps, hinted_substeps(population))
        periods = population.parameters.get("tau_refrac", np.empty(0))
        yield from _first_between(population.label, periods[periods > step_ms], step_ms)


def _first_between(label: str, times_ms: FloatArray, step_ms: float) -> Iterator[tuple[str, float, float]]:
    steps = times_ms / step_ms
    ticks = np.ceil(steps - _ROUNDING)
    between = np.flatnonzero(ticks - steps > _ROUNDING)
    if between.size:
        first = between[0]
        yield label, float(times_ms[first]), float(ticks[first]) * step_ms


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
