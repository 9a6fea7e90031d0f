"""Synapses that transmit voltages: gap junctions and graded release.

In each step a cell receives a constant current, computed from the voltages in the middle of the step.
There a voltage is ``v + (own + response current) / 2``: ``own`` is how much other causes changed it in the
last step, which is extrapolated; the change by the current itself is implicit. So all currents of a step are
one system of equations. It is solved by the method of Gauss and Seidel, which converges because a junction
moves both voltages towards each other.

The error of a step is of third order, so that of the voltages is of second order, and strong couplings are
stable. NEST solves the same equations by iterating all cells (Hahne et al. 2015, Front Neuroinform 9:22).

Between two steps a voltage may jump; the jump of a reset is not extrapolated.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, isnan
from types import MappingProxyType
from typing import Final

import numpy as np

from nrp_brain_event.cells import NANO
from nrp_brain_event.grid.equations.blocks import places_of, responses_mv
from nrp_brain_event.grid.records import (
    GAP,
    RECTIFIED,
    SET_CURVED_CURRENT,
    SIGMOID,
    Coupled,
    Coupling,
    Grid,
    V,
)
from nrp_brain_event.handles import call, opened
from nrp_brain_event.neuron import voltage_at
from nrp_brain_event.records import HODGKIN_HUXLEY, IZHIKEVICH, Array, constant
from nrp_brain_event.runge_kutta import PER_NA
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import inlined
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.synapses import ELECTRICAL, GRADED
from nrp_core.network.synapses import RECTIFIED as RECTIFIED_LAW
from nrp_core.network.voltages import VOLTAGE

_NO_CHANGE: Final[Mapping[str, FloatArray]] = MappingProxyType({})
_MV: Final = 1e-3
_EXACT_MV: Final = 1e-9
"""Largest change of a voltage in the last iteration."""
_MOST_ITERATIONS: Final = constant(10_000)


_LAWS: Final = {ELECTRICAL: GAP, GRADED: SIGMOID, RECTIFIED_LAW: RECTIFIED}
_STEEPEST: Final = 500.0
"""Largest exponent."""


def couplings_of(
    network: Network, row_of: IntArray, step_ms: float, weights_now: Mapping[str, FloatArray] = _NO_CHANGE
) -> Array:
    """Return the couplings of a network in the order of their targets; sources and targets are rows.

    A gap junction is one coupling in each direction.

    Args:
        network: the network.
        row_of: rows of its cells, by global id.
        step_ms: length of a step, ms.
        weights_now: changed weights of projections, by label.
    """
    parts = [np.empty(0, Coupling.dtype())]
    for projection in network.projections:
        if projection.is_continuous:
            part = np.zeros(projection.size, Coupling.dtype())
            part["source"] = row_of[network.offsets[projection.pre] + projection.pre_index]
            part["target"] = row_of[network.offsets[projection.post] + projection.post_index]
            part["weight"] = weights_now.get(projection.label, projection.weight)
            part["law"] = _LAWS[projection.synapse_type]
            parts.append(part)
            if projection.is_electrical:
                back = part.copy()
                back["source"], back["target"] = part["target"], part["source"]
                parts.append(back)
            else:
                _set_release(part, projection, network.populations[projection.post], step_ms)
    whole = np.concatenate(parts).view(Coupling.dtype())
    return whole[np.argsort(whole["target"], kind="stable")]


def _set_release(part: Array, projection: Projection, post: Population, step_ms: float) -> None:
    parameters = projection.synapse_parameters
    part["v_th"], part["slope"] = parameters["v_th"], parameters["slope"]
    part["receptor"] = post.receptor_number(projection.receptor) if post.is_conductance_based else -1
    scale = 1.0
    if post.equations is not None:
        scale = post.weight_unit(projection.receptor).scale / NANO
    part["weight"] *= scale
    with np.errstate(divide="ignore"):
        part["kept"] = np.exp(-0.5 * step_ms / parameters["tau_s"])


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
    couplings = couplings_of(network, row_of, float(grid.clock["h"][0]))
    rows = np.union1d(couplings["source"], couplings["target"])
    if not len(rows):
        return grid
    coupled = np.zeros(len(rows), Coupled.dtype())
    for name in ("source", "target"):
        couplings[name] = np.searchsorted(rows, couplings[name])
    coupled["row"], coupled["steady"] = rows, grid.drive[rows] * (grid.cell_rows[rows] < 0)
    for name, side in (("first", "left"), ("last", "right")):
        numbers = np.arange(len(rows))
        coupled[name] = np.searchsorted(couplings["target"], numbers, side)  # type: ignore[call-overload]
    coupled["place"], _ = places_of(grid, network, rows, VOLTAGE)
    coupled["v"], own = cells["path"][rows, 0, 0], coupled["place"] >= 0
    coupled["v"][own] = grid.values[coupled["place"][own]] / _MV
    coupled["jumps"] = cells["membrane"][rows] != HODGKIN_HUXLEY
    for label, cell in _in_equations(network):
        inside = np.isin(rows, row_of[network.ids_of(label)])
        coupled["jumps"][inside] = VOLTAGE in dict(cell.model.reset)
    _set_shares(couplings, coupled["v"])
    coupled_rows = np.full(len(cells), -1)
    coupled_rows[rows] = np.arange(len(rows))
    grid = grid._replace(coupled=coupled, couplings=couplings, coupled_rows=coupled_rows)
    return with_responses(grid, cells, network, row_of)


def _set_shares(couplings: Array, voltages: FloatArray) -> None:
    """Set the shares that act at time 0 to those of the initial voltages, mV."""
    above = (voltages[couplings["source"]] - couplings["v_th"]) / np.where(
        couplings["law"] == GAP, 1.0, couplings["slope"]
    )
    sigmoid = 1.0 / (1.0 + np.exp(np.minimum(-above, _STEEPEST)))
    couplings["s"] = np.where(couplings["law"] == SIGMOID, sigmoid, np.maximum(above, 0.0))


def with_responses(grid: Grid, cells: Array, network: Network, row_of: IntArray) -> Grid:
    """Return the grid with the data of its couplings that depend on the parameters of cells.

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
    couplings = grid.couplings.copy()
    targets = cells[rows[couplings["target"]]]
    couplings["reversal"] = np.where(couplings["receptor"] == 1, targets["e_rev_I"], targets["e_rev_E"])
    return grid._replace(coupled=coupled, couplings=couplings)


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
    for c in range(len(grid.couplings)):
        coupling = grid.couplings[c]
        coupling.s = _share(coupling, cells[coupling.source].middle, coupling.kept * coupling.kept)
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
            v = grid.coupled[coupling.source].middle
            acting = coupling.weight * _share(coupling, v, coupling.kept)
            if coupling.receptor < 0:
                inward += acting
            else:
                inward += acting * (v if coupling.law == GAP else coupling.reversal)
                conductance += acting
        alone = cell.v + 0.5 * cell.own
        cell.current = (inward - conductance * alone) / (1.0 + 0.5 * conductance * cell.response)
        middle = alone + 0.5 * cell.response * cell.current
        largest = max(largest, abs(middle - cell.middle))
        cell.middle = middle
    return largest


@inlined
def _share(coupling: Coupling, v: float, kept: float) -> float:
    """Return the share of a weight that acts under a voltage of the source, mV.

    Args:
        coupling: the coupling.
        v: the voltage.
        kept: the fraction of an earlier share that remains.
    """
    if coupling.law == GAP:
        return 1.0
    above = (v - coupling.v_th) / coupling.slope
    share = max(above, 0.0) if coupling.law == RECTIFIED else 1.0 / (1.0 + exp(min(-above, _STEEPEST)))
    return share + (coupling.s - share) * kept


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
