"""The cells of a network as records of the engine, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Final

import numpy as np

from nrp_brain_event.cell_types import CELL_TYPES, GATES, TIME_CONSTANTS, CellType
from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL,
    EQUATIONS,
    HODGKIN_HUXLEY,
    IZHIKEVICH,
    JUMP,
    START,
    Array,
    Cell,
)
from nrp_brain_event.runge_kutta import gate_rates
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.data import Network, Population
from nrp_core.network.equations.model import INPUT

NANO: Final = 1e-9
_IZHIKEVICH_PEAK_MV: Final = 30.0
_HODGKIN_HUXLEY_THRESHOLD_MV: Final = -20.0
_UPSTROKE_MS: Final = 1e-9
"""Distance from an infinite voltage at which an exponential cell fires at the latest."""
_SHORTEST_STEP_MS: Final = 1e-8
_REMAINING: Final = {"gsyn_exc": 0, "gsyn_inh": 1, "isyn_exc": 0, "isyn_inh": 1}
"""PyNN's names of the synaptic variables, and their synapse."""


def load_cells(network: Network, tolerance_mv: float, *, quadrature: bool = False) -> tuple[Array, IntArray]:
    """Return the records of all cells that are not sources, and their rows by global id.

    State variables that the network does not set start at PyNN's initial values; the gates of HH_cond_exp at
    their steady state for the initial voltage.

    Raises:
        NetworkError: a parameter or state variable is missing, unknown or impossible.
    """
    row_of = np.full(network.size, -1)
    simulated = [population for population in network.populations.values() if not population.is_source]
    cells = np.zeros(sum(population.size for population in simulated), Cell.dtype())
    first = 0
    for population in simulated:
        rows = slice(first, first + population.size)
        ids = network.ids_of(population.label)
        row_of[ids] = np.arange(rows.start, rows.stop)
        cells["id"][rows] = ids
        cells["tolerance"][rows], cells["quadrature"][rows] = tolerance_mv, quadrature
        if population.equations is None:
            _load_population(cells[rows], population, int(ids[0]))
        else:
            _load_equations(cells[rows], population)
        first = rows.stop
    return cells, row_of


def _load_equations(cells: Array, population: Population) -> None:
    """Pass the parameters of equation cells to the engine; a kernel advances the cells."""
    cells["membrane"], cells["synapse"] = EQUATIONS, JUMP
    for name in ("tau_m", "cm", "tau_syn"):  # avoids division by zero
        cells[name] = 1.0
    cells["first_stored"] = cells["last_stored"] = -1
    current = population.parameters.get(INPUT)
    if current is not None:
        assert population.equations is not None
        cells["i_offset"] = current * (population.equations.model.parameters[INPUT].scale / NANO)


def with_parameters(
    cells: Array, population: Population, values: Mapping[str, FloatArray], first_id: int
) -> Array:
    """Return records of cells of a population under other parameters, at rest.

    Args:
        cells: the records.
        population: the population of the cells.
        values: the parameters that change, one for each record.
        first_id: global id of the population's first cell.

    Raises:
        NetworkError: a parameter is impossible.
    """
    parameters = {**_parameters_of(cells, CELL_TYPES[population.cell_type]), **values}
    fresh = np.zeros(len(cells), cells.dtype)
    for name in ("id", "tolerance", "quadrature"):
        fresh[name] = cells[name]
    some = replace(population, size=len(cells), parameters=parameters, initial_values={}, positions_um=None)
    _load_population(fresh, some, first_id)
    return fresh


def _parameters_of(cells: Array, kind: CellType) -> dict[str, FloatArray]:
    """Return the parameters of records of one type, by PyNN's names."""
    return {
        name: cells["tau_syn"][:, TIME_CONSTANTS[name]] if name in TIME_CONSTANTS else cells[name]
        for name in kind.parameters
    }


def _load_population(cells: Array, population: Population, first_id: int) -> None:
    kind = CELL_TYPES[population.cell_type]
    where = f"population '{population.label}' ({population.cell_type})"
    numbers = cells["id"] - first_id
    cells["membrane"], cells["synapse"] = kind.membrane, kind.synapse
    for name in ("tau_m", "cm", "tau_syn"):  # avoids division by zero
        cells[name] = 1.0
    for name in kind.parameters:
        if name in TIME_CONSTANTS:
            cells["tau_syn"][:, TIME_CONSTANTS[name]] = population.parameters[name]
        else:
            cells[name] = population.parameters[name]
    _derive(cells, kind)
    _check_reset(where, cells, kind, numbers)
    _load_state(cells, kind, population.initial_values)


def _derive(cells: Array, kind: CellType) -> None:
    """Set the fields derived from the parameters."""
    cells["leak"], cells["per_cm"] = 1.0 / cells["tau_m"], 1.0 / cells["cm"]
    cells["fading"], cells["resistance"] = 1.0 / cells["tau_syn"], cells["tau_m"] / cells["cm"]
    cells["threshold"], cells["scale"] = cells["v_thresh"], 1.0
    cells["longest_step"], cells["shortest_step"] = cells["tau_m"], _SHORTEST_STEP_MS
    if kind.membrane == ADAPTIVE_EXPONENTIAL:
        steepest = cells["v_thresh"] + cells["delta_T"] * np.log(cells["tau_m"] / _UPSTROKE_MS)
        peak = np.minimum(cells["v_spike"], steepest)
        cells["threshold"] = np.where(cells["delta_T"] > 0.0, peak, cells["v_thresh"])
        cells["shortest_step"] = _UPSTROKE_MS / 1000
        cells["longest_step"] = np.minimum(cells["tau_m"], cells["tau_w"])
        cells["scale"] = cells["cm"] / cells["tau_m"]
    elif kind.membrane == IZHIKEVICH:
        cells["threshold"], cells["longest_step"] = _IZHIKEVICH_PEAK_MV, 1.0
    elif kind.membrane == HODGKIN_HUXLEY:
        cells["threshold"], cells["longest_step"] = _HODGKIN_HUXLEY_THRESHOLD_MV, 0.1
        cells["scale"] = 0.01  # a gate per mV
    cells["next_step"] = 0.1 * cells["longest_step"]


def _check_reset(where: str, cells: Array, kind: CellType, numbers: IntArray) -> None:
    """Refuse cells that would fire infinitely often at one time."""
    if kind.membrane == HODGKIN_HUXLEY:
        return
    reset = cells["c"] if kind.membrane == IZHIKEVICH else cells["v_reset"]
    endless = (reset >= cells["threshold"]) & (cells["tau_refrac"] == 0.0)
    if endless.any():
        cell = int(np.flatnonzero(endless)[0])
        raise NetworkError(
            f"{where}: cell {numbers[cell]} has no refractory time and is reset to {reset[cell]:g} mV, "
            f"where it fires again at once (threshold {cells['threshold'][cell]:g} mV)"
        )


def _load_state(cells: Array, kind: CellType, given: Mapping[str, FloatArray]) -> None:
    for name in _REMAINING.keys() & given.keys():
        cells["x"][:, _REMAINING[name]] = given[name]
    state = [given.get(name, np.full(len(cells), value)) for name, value in kind.initial.items()]
    cells["armed"] = 1
    if kind.membrane == HODGKIN_HUXLEY:
        state += _gates(given, state[0] - cells["v_offset"])
        cells["armed"] = state[0] < cells["threshold"]
    for variable, values in enumerate(state):
        cells["path"][:, variable, 0] = values
    cells["step"], cells["on_wake"] = inf, START
    cells["first_stored"] = cells["last_stored"] = -1


def _gates(given: Mapping[str, FloatArray], voltages: FloatArray) -> list[FloatArray]:
    gates = []
    for gate, name in enumerate(GATES, start=1):
        rates = [gate_rates(gate, voltage) for voltage in voltages.tolist()]
        settled = np.array([opening / (opening + closing) for opening, closing in rates])
        gates.append(given.get(name, settled))
    return gates
