"""Loads the populations of a network whose cells are given as equations.

How large coefficients may be for a whole step of :mod:`nrp_brain_event.grid.equations.exact_source`.

With A and B the integrals of abs(a) and abs(a x) + abs(b), and r the share by which coefficients change in
the step, the terms of fifth order that the expansion leaves out (Blanes et al. 2009, section 4) are at most
``A r (A + r)**2 B / 90`` together, and the remainder of the approximant is ``A**4 B / 720``: both are less
than ``(A + r)**4 B / 240``. Twice that is compared with the tolerance, for the terms of higher order.

That is too much to compute in each step. So what is due to b is measured in a value of x, the ``reach`` E:
if S is a sum of sizes of which none is smaller than its part of A and of b / E, the bound is
``(S + r)**4 S (abs(x) + E) / 240``. It meets the tolerance ``T (s + abs(x))`` for all S below a function of
abs(x) that is concave, so its chord between 0 and E is below it, and it grows beyond E.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from nrp_brain_event.cells import NANO
from nrp_brain_event.equation_source import DEFINITION, PARAMETER, STATE, compiled
from nrp_brain_event.grid.equations.exact_source import MOST_CHANGE
from nrp_brain_event.grid.equations.layout import (
    CHANGE,
    STREAM,
    TOLERANCE,
    constants_of,
    courses_of,
    factors_of,
    length_of_row,
    multiplied,
    propagated,
    scale_of,
    values_of,
)
from nrp_brain_event.grid.equations.source import ARGUMENTS, kernel_source
from nrp_brain_event.grid.records import N_STATE, Block, Grid, X
from nrp_brain_event.random_numbers import streams
from nrp_brain_event.records import Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import CapabilityError, did_you_mean
from nrp_core.findings.refusals import no_variable
from nrp_core.network.changes import ParameterChange
from nrp_core.network.data import Network, Population
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.expressions import TIME
from nrp_core.network.equations.linear import ONE, driven, fastest, integrals, propagators
from nrp_core.network.equations.model import INPUT, Model, value_of
from nrp_core.network.voltages import VOLTAGE
from nrp_core.seeds import Seeds

SAFETY: Final = 120.0
_HALVINGS: Final = 50


class Bound(NamedTuple):
    """Says that a whole step is right if ``sum(size * abs(column)) < least + slope * min(abs(x), reach)``.

    Args:
        least, slope, reach: by cell.
        size: by column, then by cell; constant values are in ``least``.
    """

    least: FloatArray
    slope: FloatArray
    reach: FloatArray
    size: Mapping[str, FloatArray]


def bound(
    size_a: Mapping[str, FloatArray], size_b: Mapping[str, FloatArray], change: FloatArray, scale: float
) -> Bound:
    """Return the bound for each cell.

    Args:
        size_a: sizes of :class:`~nrp_core.network.equations.linear.Integrals` of a, by column.
        size_b: the sizes of b.
        change: the share by which coefficients change in a step.
        scale: see :func:`nrp_brain_event.grid.equations.layout.scale_of`.
    """
    zero = np.zeros_like(change)
    reach = zero + scale
    for key, of_a in size_a.items():
        ratio = np.divide(size_b.get(key, zero), of_a, out=zero.copy(), where=of_a > 0.0)
        reach = np.maximum(reach, ratio)
    size = {
        key: np.maximum(size_a.get(key, zero), size_b.get(key, zero) / reach)
        for key in dict.fromkeys([*size_a, *size_b])
    }
    constant = size.pop(ONE, zero)
    least = _largest(scale / reach, change)
    slope = (_largest((scale + reach) / (2.0 * reach), change) - least) / reach
    return Bound(least - constant, slope, reach, size)


def _largest(share: FloatArray, change: FloatArray) -> FloatArray:
    """Return the S at which ``(S + change)**4 S`` is a share of the tolerance, or a little less."""
    allowed = SAFETY * TOLERANCE * share
    low, high = np.zeros_like(allowed), allowed**0.2
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_low = (middle + change) ** 4 * middle < allowed
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    return low


_S_PER_MS: Final = 1e-3
_MOST_RECEPTORS: Final = N_STATE - X
"""The rows of the state on which spikes act; cells with equations keep nothing else there."""


def load_blocks(network: Network, row_of: IntArray, step_ms: float) -> dict[str, Array]:
    """Return the arrays of all populations with equations, at time 0.

    Raises:
        CapabilityError: equations have too many receptors.
    """
    owners = list(owners_of(network))
    for population, cell in owners:
        if len(cell.model.receptors) > _MOST_RECEPTORS:
            raise CapabilityError(
                f"the equations of population '{population.label}' have {len(cell.model.receptors)} "
                f"receptors; on 'event' they have at most {_MOST_RECEPTORS}"
            )
    blocks = np.zeros(len(owners), Block.dtype())
    values, constants = [np.empty(0)], [np.empty(0)]
    for block, (population, cell) in zip(blocks, owners, strict=True):
        block["first"] = row_of[network.offsets[population.label]]
        block["last"] = block["first"] + population.size
        block["value"], block["constant"] = sum(map(len, values)), sum(map(len, constants))
        values.append(_values(population, cell))
        known = cell.in_si(population.parameters)
        constants.append(_constants(cell.model, known, population.size, step_ms))
    every = np.concatenate(constants)
    coded = _with_code(blocks, every, network)
    return {"blocks": coded, "values": np.concatenate(values), "constants": every}


def with_code(grid: Grid, network: Network) -> Grid:
    """Return a grid, whose constants are others, with the kernels for these."""
    return grid._replace(blocks=_with_code(grid.blocks, grid.constants, network))


def with_parameters(grid: Grid, network: Network, change: ParameterChange) -> Grid:
    """Return the grid with other parameters of a population; the state of its cells stays.

    Raises:
        NetworkError: a parameter is impossible.
    """
    block, population, cell = _owner(grid, network, change.label)
    known = parameters_of(grid, block, population.size, cell.model)
    for name, values in change.values.items():
        known[name] = known[name].copy()
        known[name][change.index] = values * cell.model.parameters[name].scale
    cell.require_periods(f"population '{change.label}'", known)
    first, constants = int(block["constant"]), grid.constants.copy()
    fresh = _constants(cell.model, known, population.size, float(grid.clock["h"][0]))
    constants[first : first + len(fresh)] = fresh
    return with_code(grid._replace(constants=constants), network)


def offsets_na(grid: Grid, network: Network, label: str) -> FloatArray | float:
    """Return the constant current into the cells of a population with equations, nA."""
    block, population, cell = _owner(grid, network, label)
    return parameters_of(grid, block, population.size, cell.model).get(INPUT, 0.0) / NANO


def responses_mv(grid: Grid, network: Network, label: str) -> FloatArray:
    """Return how much 1 nA changes the voltage ``v`` of the cells of a population in a step, mV.

    Raises:
        CapabilityError: the current does not act on the voltage.
    """
    block, population, cell = _owner(grid, network, label)
    variables = {
        name: population.initial_values.get(name, np.zeros(1)) * variable.unit.scale
        for name, variable in cell.model.variables.items()
    }
    known: dict[str, Any] = {
        TIME: 0.0,
        **parameters_of(grid, block, population.size, cell.model),
        **variables,
    }
    rates = [
        value_of(
            cell.model.variables[VOLTAGE].rate, known | {INPUT: known[INPUT] + extra}, cell.model.definitions
        )
        for extra in (0.0, NANO)
    ]
    found: FloatArray = (rates[1] - rates[0]) * float(grid.clock["h"][0])  # V/s and ms
    if not (found > 0.0).all():
        raise CapabilityError(
            f"the voltage '{VOLTAGE}' of population '{label}' does not rise with the current '{INPUT}', by "
            "which voltages of other cells act on it"
        )
    return np.broadcast_to(found, population.size)


def require_input(network: Network, currents_na: FloatArray) -> None:
    """Refuse currents into cells whose equations lack a current.

    Args:
        network: the network.
        currents_na: by global id.

    Raises:
        CapabilityError: a cell takes no current.
    """
    for population, cell in owners_of(network):
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
    for population, cell in owners_of(network):
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
    for block, (population, cell) in zip(grid.blocks, owners_of(network), strict=True):
        own, model = (rows >= block["first"]) & (rows < block["last"]), cell.model
        if not own.any():
            continue
        unit = model.unit_of(variable)
        if unit is None:
            raise no_variable(population.label, variable, [*model.variables, *model.recorded])
        prefix = STATE if variable in model.variables else DEFINITION
        number = values_of(model).index(prefix + variable)
        places[own] = block["value"] + number * length_of_row(population.size) + rows[own] - block["first"]
        sizes[own] = unit.scale
    return places, sizes


def begin_cell_streams(grid: Grid, network: Network, seeds: Seeds) -> None:
    """Begin the streams of the cells whose threshold is random."""
    for block, (population, cell) in zip(grid.blocks, owners_of(network), strict=True):
        if cell.model.is_random:
            number = values_of(cell.model).index(STREAM)
            first = block["value"] + number * length_of_row(population.size)
            seed = seeds.integer(f"population/{population.label}", 62)
            grid.values[first : first + population.size] = streams(population.size, seed)


def owners_of(network: Network) -> list[tuple[Population, CellEquations]]:
    """Return the populations whose cells are given as equations, and these."""
    every = ((population, population.equations) for population in network.populations.values())
    return [(population, cell) for population, cell in every if cell is not None]


def _owner(grid: Grid, network: Network, label: str) -> tuple[Any, Population, CellEquations]:
    owners = zip(grid.blocks, owners_of(network), strict=True)
    return next((block, *owner) for block, owner in owners if owner[0].label == label)


def _with_code(blocks: Array, constants: FloatArray, network: Network) -> Array:
    """Return blocks with a kernel each: cells that differ in constants have another one than equal cells."""
    blocks = blocks.copy()
    for block, (population, cell) in zip(blocks, owners_of(network), strict=True):
        known = _rows(constants, block, population.size, cell.model)
        differ = {name for name, row in known.items() if (row != row[:1]).any()}
        is_driven = CHANGE in known and bool((known[CHANGE] <= MOST_CHANGE).all())
        source = kernel_source(cell.model, equal=differ <= {PARAMETER + INPUT}, driven=is_driven)
        block["code"] = compiled(source, "advance", ARGUMENTS)
    return blocks


def _values(population: Population, cell: CellEquations) -> FloatArray:
    """Return the initial values of state variables, hidden variables and recorded definitions."""
    model = cell.model
    found = np.zeros((len(values_of(model)), length_of_row(population.size)))
    used = found[:, : population.size]
    known: dict[str, Any] = {TIME: 0.0, **cell.in_si(population.parameters)}
    for row, (name, variable) in zip(used, model.variables.items(), strict=False):
        row[:] = population.initial_values.get(name, np.zeros(1)) * variable.unit.scale
        known[name] = row
    for row, name in zip(used[len(used) - len(model.recorded) :], model.recorded, strict=True):
        row[:] = value_of(model.definitions[name], known, model.definitions)
    return found.ravel()


def parameters_of(grid: Grid, block: Any, n: int, model: Model) -> dict[str, FloatArray]:
    """Return the present parameters of a population of n cells, in SI units."""
    rows = _rows(grid.constants, block, n, model)
    return {name: rows[PARAMETER + name] for name in model.parameters}


def _rows(constants: FloatArray, block: Any, n: int, model: Model) -> dict[str, FloatArray]:
    """Return the constants of a population of n cells by their names in a kernel."""
    names, first, length = constants_of(model), block["constant"], length_of_row(n)
    rows = constants[first : first + len(names) * length].reshape(len(names), length)
    return dict(zip(names, rows[:, :n], strict=True))


def _constants(model: Model, known: Mapping[str, FloatArray], n: int, step_ms: float) -> FloatArray:
    """Return the constants of n cells, concatenated; each has one value per cell."""
    gains = [
        value_of(effect.factor, known, model.definitions) * effect.unit.scale
        for effect in model.receptors.values()
    ]
    rows = [*(known[name] for name in model.parameters), *gains]
    part = propagated(model)
    for course in courses_of(model) if part.variables else ():
        moved = propagators(part, known, n, course.share * step_ms * _S_PER_MS, held=course.held)
        rows += list(moved[:, multiplied(part, held=course.held)].T)
    if factors_of(model):
        rows += _factors(model, known, n, step_ms * _S_PER_MS)
    found = np.zeros((len(rows), length_of_row(n)))
    for whole, row in zip(found, rows, strict=True):
        whole[:n] = row
    return found.ravel()


def _factors(model: Model, known: Mapping[str, FloatArray], n: int, step_s: float) -> list[FloatArray]:
    """Return the constants of variables that are driven, see :func:`factors_of`."""
    change = fastest(model, known, n, step_s)
    rows = [change]
    for name, both in (driven(model) or {}).items():
        a, b = (integrals(model, own, known, n, step_s) for own in both)
        limits = bound(a.size, b.size, change, scale_of(model.variables[name]))
        sums = (a.whole, a.moment, b.whole, b.moment)
        rows += [row for own in sums for row in own.values()]
        rows += [limits.least, limits.slope, limits.reach, *limits.size.values()]
    return rows
