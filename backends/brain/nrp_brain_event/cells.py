"""The cells of a network as records of the engine, checked."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

import numpy as np
from nrp_core.brain.network import FloatArray, IntArray, Network, Population
from nrp_core.errors import NetworkError, did_you_mean

from nrp_brain_event.cell_types import (
    CELL_TYPES, HODGKIN_HUXLEY_THRESHOLD_MV, IZHIKEVICH_PEAK_MV, MAY_BE_INFINITE, NOT_NEGATIVE, POSITIVE,
    TIME_CONSTANTS, CellType,
)  # fmt: skip
from nrp_brain_event.membranes import gate_rates
from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL, CELL, HODGKIN_HUXLEY, IZHIKEVICH, START, Array,
)  # fmt: skip


def load_cells(network: Network, tolerance_mv: float) -> tuple[Array, IntArray]:
    """Return the records of all cells that are not sources, and their rows by global id.

    Raises:
        NetworkError: a parameter is missing, unknown or impossible.
    """
    row_of = np.full(network.size, -1)
    simulated = [p for p in network.populations.values() if not p.is_source]
    cells = np.zeros(sum(p.size for p in simulated), CELL)
    first = 0
    for population in simulated:
        rows = slice(first, first + population.size)
        ids = network.ids_of(population.label)
        row_of[ids] = np.arange(first, first + population.size)
        cells["id"][rows] = ids
        _load_parameters(cells[rows], population)
        _load_state(cells[rows], population)
        first += population.size
    cells["tolerance"] = tolerance_mv
    return cells, row_of


def _load_parameters(cells: Array, population: Population) -> None:
    kind = CELL_TYPES[population.cell_type]
    _check(population, kind)
    cells["membrane"], cells["synapse"] = kind.membrane, kind.synapse
    for name in ("tau_m", "cm", *TIME_CONSTANTS):  # so that no formula divides by zero
        cells[name] = 1.0
    for name in kind.parameters:
        cells[name] = population.parameters[name]
    cells["leak"], cells["per_cm"] = 1.0 / cells["tau_m"], 1.0 / cells["cm"]
    cells["scale"] = 1.0
    cells["threshold"] = cells["v_thresh"]
    cells["longest_step"] = cells["tau_m"]
    if kind.membrane == ADAPTIVE_EXPONENTIAL:
        cells["threshold"] = np.where(cells["delta_T"] > 0.0, cells["v_spike"], cells["v_thresh"])
        cells["scale"] = cells["cm"] / cells["tau_m"]
        cells["longest_step"] = np.minimum(cells["tau_m"], cells["tau_w"])
    elif kind.membrane == IZHIKEVICH:
        cells["threshold"] = IZHIKEVICH_PEAK_MV
        cells["longest_step"] = 1.0
    elif kind.membrane == HODGKIN_HUXLEY:
        cells["threshold"] = HODGKIN_HUXLEY_THRESHOLD_MV
        cells["scale"] = 0.01
        cells["longest_step"] = 0.1
    cells["next_step"] = 0.1 * cells["longest_step"]
    _check_reset(cells, population)


def _check(population: Population, kind: CellType) -> None:
    where = f"population '{population.label}' ({population.cell_type})"
    for name in population.parameters:
        if name not in kind.parameters:
            raise NetworkError(f"{where} has no parameter '{name}'{did_you_mean(name, kind.parameters)}")
    for name in kind.parameters:
        if name not in population.parameters:
            raise NetworkError(f"{where} needs the parameter '{name}'")
        values = population.parameters[name]
        wrong = ~np.isfinite(values) if name not in MAY_BE_INFINITE else values == -inf
        demand = "must be finite"
        if name in POSITIVE:
            wrong, demand = ~(np.isfinite(values) & (values > 0)), "must be positive"
        elif name in NOT_NEGATIVE:
            wrong, demand = ~(np.isfinite(values) & (values >= 0)), "must be 0 or more"
        if wrong.any():
            cell = int(np.flatnonzero(wrong)[0])
            raise NetworkError(f"{where}: {name} of cell {cell} is {values[cell]:g}; it {demand}")


def _check_reset(cells: Array, population: Population) -> None:
    """Refuse cells that would fire without end at one instant."""
    reset = cells["c"] if cells["membrane"][0] == IZHIKEVICH else cells["v_reset"]
    endless = (reset >= cells["threshold"]) & (cells["tau_refrac"] == 0)
    if endless.any() and cells["membrane"][0] != HODGKIN_HUXLEY:
        cell = int(np.flatnonzero(endless)[0])
        raise NetworkError(
            f"population '{population.label}': cell {cell} is reset to {reset[cell]:g} mV, where it fires "
            f"again at once (threshold {cells['threshold'][cell]:g} mV) and has no refractory time"
        )


def _load_state(cells: Array, population: Population) -> None:
    kind = CELL_TYPES[population.cell_type]
    given = population.initial_values
    synaptic = {"gsyn_exc": "x_e", "gsyn_inh": "x_i", "isyn_exc": "x_e", "isyn_inh": "x_i"}
    gates = ("m", "h", "n") if kind.membrane == HODGKIN_HUXLEY else ()
    for name in given:
        if name not in kind.initial and name not in synaptic and name not in gates:
            known = (*kind.initial, *gates, *synaptic)
            raise NetworkError(
                f"population '{population.label}' ({population.cell_type}) has no state variable "
                f"'{name}'{did_you_mean(name, known)}"
            )
    for name in synaptic.keys() & given.keys():
        cells[synaptic[name]] = given[name]
    state = [_initial(given, name, value, len(cells)) for name, value in kind.initial.items()]
    if kind.membrane == HODGKIN_HUXLEY:
        state += _gates(given, state[0] - cells["v_offset"])
    for variable, values in enumerate(state):
        cells["path"][:, variable, 0] = values
    cells["step"] = inf
    cells["armed"] = state[0] < cells["threshold"] if kind.membrane == HODGKIN_HUXLEY else True
    cells["on_wake"] = START
    cells["arrivals"] = cells["slot"] = cells["before"] = cells["after"] = -1


def _initial(given: Mapping[str, FloatArray], name: str, value: float, size: int) -> FloatArray:
    return given[name] if name in given else np.full(size, value)


def _gates(given: Mapping[str, FloatArray], voltages: FloatArray) -> list[FloatArray]:
    """Return the initial gates m, h, n; where they are not given, what they settle at."""
    gates = []
    for gate, name in enumerate("mhn", start=1):
        rates = [gate_rates(gate, voltage) for voltage in voltages.tolist()]
        settled = np.array([opening / (opening + closing) for opening, closing in rates])
        gates.append(given.get(name, settled))
    return gates
