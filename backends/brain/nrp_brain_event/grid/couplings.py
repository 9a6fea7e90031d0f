"""Synapses that transmit voltages: gap junctions.

In each step a cell receives a constant current: the one that the voltages in the middle of the step cause.
There a voltage is ``v + (own + response current) / 2``: ``own`` is how much other causes changed it in the
last step, which is extrapolated; the change by the current itself is implicit. So all currents of a step are
one system of equations. It is solved by the method of Gauss and Seidel, which converges because a junction
moves both voltages towards each other.

The error of a step is of third order, so that of the voltages is of second order, and strong couplings are
stable. NEST solves the same equations by iterating all cells (Hahne et al. 2015, Front Neuroinform 9:22).

Between two steps, a voltage may jump: what a reset changes is not extrapolated.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_event.grid.equations.blocks import places_of, responses_mv
from nrp_brain_event.grid.records import SET_CURVED_CURRENT, Coupled, Coupling, Grid, V
from nrp_brain_event.handles import call, opened
from nrp_brain_event.neuron import voltage_at
from nrp_brain_event.records import HODGKIN_HUXLEY, IZHIKEVICH, Array, constant
from nrp_brain_event.runge_kutta import PER_NA
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import inlined
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.network.voltages import VOLTAGE

_MV: Final = 1e-3
_EXACT_MV: Final = 1e-9
"""Largest change of a voltage in the last iteration."""
_MOST_ITERATIONS: Final = constant(10_000)


class Couplings(NamedTuple):
    """What acts on cells by the voltages of others, in the order of the targets.

    Args:
        source, target: rows.
        weight: uS.
    """

    source: IntArray
    target: IntArray
    weight: FloatArray


def couplings_of(
    network: Network, row_of: IntArray, weights_now: Mapping[str, FloatArray] = MappingProxyType({})
) -> Couplings:
    """Return the couplings of a network; a gap junction is one in each direction.

    Args:
        network: the network.
        row_of: rows of its cells, by global id.
        weights_now: changed weights of projections, by label.
    """
    parts = [Couplings(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))]
    for projection in network.projections:
        if projection.is_continuous:
            source = row_of[network.offsets[projection.pre] + projection.pre_index]
            target = row_of[network.offsets[projection.post] + projection.post_index]
            weight = weights_now.get(projection.label, projection.weight)
            parts += [Couplings(source, target, weight), Couplings(target, source, weight)]
    source, target, weight = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(target, kind="stable")
    return Couplings(source[order], target[order], weight[order])


def no_couplings() -> dict[str, Array]:
    """Return the arrays of a grid on which no voltage acts on another."""
    return {
        "coupled": np.empty(0, Coupled.dtype()),
        "couplings": np.empty(0, Coupling.dtype()),
        "coupled_rows": np.empty(0, np.int64),
    }


def with_couplings(grid: Grid, cells: Array, network: Network, row_of: IntArray) -> Grid:
    """Return the grid of a network at time 0 with its couplings.

    Args:
        grid: the grid.
        cells: the ``Cell`` in each row.
        network: the network.
        row_of: rows by global id.

    Raises:
        CapabilityError: a current does not act on the voltage of cells that are given as equations.
    """
    found = couplings_of(network, row_of)
    rows = np.union1d(found.source, found.target)
    if not len(rows):
        return grid
    couplings, coupled = np.zeros(len(found.source), Coupling.dtype()), np.zeros(len(rows), Coupled.dtype())
    couplings["source"], couplings["weight"] = np.searchsorted(rows, found.source), found.weight
    coupled["row"], coupled["steady"] = rows, grid.drive[rows] * (grid.cell_rows[rows] < 0)
    for name, side in (("first", "left"), ("last", "right")):
        coupled[name] = np.searchsorted(found.target, rows, side)  # type: ignore[call-overload]
    coupled["place"], _ = places_of(grid, network, rows, VOLTAGE)
    coupled["v"], own = cells["path"][rows, 0, 0], coupled["place"] >= 0
    coupled["v"][own] = grid.values[coupled["place"][own]] / _MV
    coupled["jumps"] = cells["membrane"][rows] != HODGKIN_HUXLEY
    for label, cell in _in_equations(network):
        inside = np.isin(rows, row_of[network.ids_of(label)])
        coupled["jumps"][inside] = VOLTAGE in dict(cell.model.reset)
    coupled_rows = np.full(len(cells), -1)
    coupled_rows[rows] = np.arange(len(rows))
    grid = grid._replace(coupled=coupled, couplings=couplings, coupled_rows=coupled_rows)
    return with_responses(grid, cells, network, row_of)


def with_responses(grid: Grid, cells: Array, network: Network, row_of: IntArray) -> Grid:
    """Return the grid with what follows, for its couplings, from the parameters of cells.

    Raises:
        CapabilityError: a current does not act on the voltage of cells that are given as equations.
    """
    coupled, rows = grid.coupled.copy(), grid.coupled["row"]
    runs = grid.runs[np.searchsorted(grid.runs["first"], rows, "right") - 1]
    coupled["rest"], coupled["reset"] = runs["v_rest"], runs["v_rest"] + runs["reset"]
    per_na = np.where(cells["membrane"][rows] == IZHIKEVICH, PER_NA, cells["per_cm"][rows])
    coupled["response"] = per_na * float(grid.clock["h"][0])
    for label, _ in _in_equations(network):
        places = grid.coupled_rows[row_of[network.ids_of(label)]] if len(rows) else np.empty(0, np.int64)
        if (places >= 0).any():
            coupled["response"][places[places >= 0]] = responses_mv(grid, network, label)[places >= 0]
    return grid._replace(coupled=coupled)


def _in_equations(network: Network) -> list[tuple[str, CellEquations]]:
    """Return the labels of the populations whose cells are given as equations, and these."""
    every = ((label, population.equations) for label, population in network.populations.items())
    return [(label, equations) for label, equations in every if equations is not None]


def couple(places: Array) -> int:
    """Set the currents that act in the next step by the voltages of other cells."""
    grid = opened(Grid, places)
    cells = grid.coupled
    for k in range(len(cells)):
        cells[k].middle = cells[k].v + 0.5 * (cells[k].own + cells[k].response * cells[k].current)
    change, n = 1.0, 0
    while change > _EXACT_MV and n < _MOST_ITERATIONS:
        change, n = _iterated(grid), n + 1
    if n == _MOST_ITERATIONS:
        grid.clock[0].failed = grid.ids[cells[0].row]
    for k in range(len(cells)):
        cell = cells[k]
        current = cell.steady + cell.current
        if grid.cell_rows[cell.row] < 0:
            grid.drive[cell.row] = current
        elif call(grid.codes[SET_CURVED_CURRENT], (places, cell.row, current)) == 0:
            grid.clock[0].failed = grid.ids[cell.row]
    return 0


@inlined
def _iterated(grid: Grid) -> float:
    """Compute all currents and voltages once more; return the largest change of a voltage, mV."""
    largest = 0.0
    for k in range(len(grid.coupled)):
        cell = grid.coupled[k]
        inward, conductance = 0.0, 0.0
        for c in range(cell.first, cell.last):
            coupling = grid.couplings[c]
            inward += coupling.weight * grid.coupled[coupling.source].middle
            conductance += coupling.weight
        alone = cell.v + 0.5 * cell.own
        cell.current = (inward - conductance * alone) / (1.0 + 0.5 * conductance * cell.response)
        middle = alone + 0.5 * cell.response * cell.current
        largest = max(largest, abs(middle - cell.middle))
        cell.middle = middle
    return largest


def follow(places: Array, step: int) -> int:
    """Note the voltages of coupled cells at the end of a step."""
    grid = opened(Grid, places)
    now = step * grid.clock[0].h
    for k in range(len(grid.coupled)):
        cell = grid.coupled[k]
        v = _voltage(grid, cell, now)
        cell.own = v - cell.v - cell.response * cell.current
        cell.v = v
    for k in range(grid.clock[0].n_fired):
        index = grid.coupled_rows[grid.fired[k]]
        if index >= 0 and grid.coupled[index].jumps:
            grid.coupled[index].own = 0.0
    return 0


@inlined
def _voltage(grid: Grid, cell: Coupled, now: float) -> float:
    """Return the voltage of a coupled cell at a grid point (ms), mV."""
    if cell.place >= 0:
        return float(grid.values[cell.place] / _MV)
    if grid.cell_rows[cell.row] >= 0:
        return voltage_at(grid.cells[grid.cell_rows[cell.row]], now)
    above = grid.state[V, cell.row]
    return float(cell.reset if isnan(above) else cell.rest + above)
