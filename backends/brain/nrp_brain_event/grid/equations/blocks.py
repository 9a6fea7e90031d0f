"""Loads the populations of a network whose cells are given as equations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from nrp_brain_event.cells import NANO
from nrp_brain_event.equations.compiled import compiled
from nrp_brain_event.grid.equations.source import ARGUMENTS, STREAM, hidden, kernel_source
from nrp_brain_event.grid.records import N_STATE, Block, Grid, X
from nrp_brain_event.random_numbers import streams
from nrp_brain_event.records import Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.changes import ParameterChange
from nrp_core.brain.network.data import Network, Population
from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.network.equations.expressions import TIME
from nrp_core.brain.network.equations.model import EXACT, INPUT, Model
from nrp_core.brain.network.equations.propagators import pattern, propagators
from nrp_core.brain.network.equations.values import value_of
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import CapabilityError, did_you_mean
from nrp_core.findings.refusals import no_variable
from nrp_core.seeds import Seeds

_S_PER_MS: Final = 1e-3
_MOST_RECEPTORS: Final = N_STATE - X
"""The rows of the state on which spikes act; cells with equations keep nothing else there."""


def load_blocks(network: Network, row_of: IntArray, step_ms: float) -> dict[str, Array]:
    """Return the arrays of all populations with equations, at time 0.

    Raises:
        CapabilityError: equations have too many receptors.
    """
    owners = list(_owners(network))
    for population, cell in owners:
        if len(cell.model.receptors) > _MOST_RECEPTORS:
            raise CapabilityError(
                f"the equations of population '{population.label}' have {len(cell.model.receptors)} "
                f"receptors; on 'event' they have at most {_MOST_RECEPTORS}"
            )
    blocks = np.zeros(len(owners), Block.dtype())
    values, constants = [np.empty(0)], [np.empty(0)]
    for block, (population, cell) in zip(blocks, owners, strict=True):
        block["code"] = compiled(kernel_source(cell.model), "advance", ARGUMENTS)
        block["first"] = row_of[network.offsets[population.label]]
        block["last"] = block["first"] + population.size
        block["value"], block["constant"] = sum(map(len, values)), sum(map(len, constants))
        values.append(_values(population, cell))
        constants.append(_constants(cell.model, cell.in_si(population.parameters), population.size, step_ms))
    return {"blocks": blocks, "values": np.concatenate(values), "constants": np.concatenate(constants)}


def with_parameters(grid: Grid, network: Network, change: ParameterChange) -> Grid:
    """Return the grid with other parameters of a population; the state of its cells stays.

    Raises:
        NetworkError: a parameter is impossible.
    """
    block, population, cell = _owner(grid, network, change.label)
    known = _parameters(grid, block, population.size, cell.model)
    for name, values in change.values.items():
        known[name] = known[name].copy()
        known[name][change.index] = values * cell.model.parameters[name].scale
    cell.require_periods(f"population '{change.label}'", known)
    first, constants = int(block["constant"]), grid.constants.copy()
    fresh = _constants(cell.model, known, population.size, float(grid.clock["h"][0]))
    constants[first : first + len(fresh)] = fresh
    return grid._replace(constants=constants)


def offsets_na(grid: Grid, network: Network, label: str) -> FloatArray | float:
    """Return the constant current into the cells of a population with equations, nA."""
    block, population, cell = _owner(grid, network, label)
    return _parameters(grid, block, population.size, cell.model).get(INPUT, 0.0) / NANO


def require_input(network: Network, currents_na: FloatArray) -> None:
    """Refuse currents into cells whose equations have none.

    Args:
        network: the network.
        currents_na: by global id.

    Raises:
        CapabilityError: a cell takes no current.
    """
    for population, cell in _owners(network):
        own = currents_na[network.ids_of(population.label)]
        if INPUT not in cell.model.parameters and own.any():
            raise CapabilityError(
                f"population '{population.label}' takes no current: its equations have no parameter '{INPUT}'"
            )


def require_receptor(network: Network, events: SynapticEvents) -> None:
    """Refuse events at a receptor that equations do not have.

    Raises:
        CapabilityError: the cells have no such receptor.
    """
    for population, cell in _owners(network):
        first, known = network.offsets[population.label], cell.model.receptors
        if events.receptor in known:
            continue
        if ((events.neurons >= first) & (events.neurons < first + population.size)).any():
            raise CapabilityError(
                f"the equations of population '{population.label}' have no {events.receptor} receptor, but a "
                f"spike arrives there{did_you_mean(events.receptor, known)}"
            )


def places_of(grid: Grid, network: Network, rows: IntArray, variable: str) -> tuple[IntArray, FloatArray]:
    """Return where a state variable of rows is among the ``values``, or -1, and the size of its unit."""
    places, sizes = np.full(len(rows), -1), np.ones(len(rows))
    for block, (population, cell) in zip(grid.blocks, _owners(network), strict=True):
        own, model = (rows >= block["first"]) & (rows < block["last"]), cell.model
        if not own.any():
            continue
        unit = model.unit_of(variable)
        if unit is None:
            raise no_variable(population.label, variable, [*model.variables, *model.recorded])
        number = [*model.variables, *hidden(model), *model.recorded].index(variable)
        places[own] = block["value"] + number * population.size + rows[own] - block["first"]
        sizes[own] = unit.scale
    return places, sizes


def begin_cell_streams(grid: Grid, network: Network, seeds: Seeds) -> None:
    """Begin the streams of the cells whose threshold is random."""
    for block, (population, cell) in zip(grid.blocks, _owners(network), strict=True):
        if cell.model.is_random:
            number = len(cell.model.variables) + hidden(cell.model).index(STREAM)
            first = block["value"] + number * population.size
            seed = seeds.integer(f"population/{population.label}", 62)
            grid.values[first : first + population.size] = streams(population.size, seed)


def _owners(network: Network) -> list[tuple[Population, CellEquations]]:
    """Return the populations whose cells are given as equations, and these."""
    every = ((population, population.equations) for population in network.populations.values())
    return [(population, cell) for population, cell in every if cell is not None]


def _owner(grid: Grid, network: Network, label: str) -> tuple[Any, Population, CellEquations]:
    owners = zip(grid.blocks, _owners(network), strict=True)
    return next((block, *owner) for block, owner in owners if owner[0].label == label)


def _values(population: Population, cell: CellEquations) -> FloatArray:
    """Return the initial values of variables, of what is hidden, and of recorded definitions."""
    model = cell.model
    found = np.zeros((len(model.variables) + len(hidden(model)) + len(model.recorded), population.size))
    known: dict[str, Any] = {TIME: 0.0, **cell.in_si(population.parameters)}
    for row, (name, variable) in zip(found, model.variables.items(), strict=False):
        row[:] = population.initial_values.get(name, np.zeros(1)) * variable.unit.scale
        known[name] = row
    for row, name in zip(found[len(found) - len(model.recorded) :], model.recorded, strict=True):
        row[:] = value_of(model.definitions[name], known, model.definitions)
    return found.ravel()


def _parameters(grid: Grid, block: Any, n: int, model: Model) -> dict[str, FloatArray]:
    """Return the present parameters of a population of n cells, in SI units."""
    names, first = model.parameters, block["constant"]
    rows = grid.constants[first : first + len(names) * n].reshape(len(names), n)
    return dict(zip(names, rows, strict=True))


def _constants(model: Model, known: Mapping[str, FloatArray], n: int, step_ms: float) -> FloatArray:
    """Return parameters and propagators of n cells, one after the other, each with one value a cell."""
    rows = [known[name] for name in model.parameters]
    regimes = [False, True] if any(variable.held for variable in model.variables.values()) else [False]
    for held in regimes if model.method == EXACT else ():
        moved = propagators(model, known, n, step_ms * _S_PER_MS, held=held)
        rows += list(moved[:, pattern(model, held=held)].T)
    return np.concatenate([np.empty(0), *(np.broadcast_to(row, (n,)) for row in rows)])
