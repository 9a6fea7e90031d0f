"""The cells of a network in NEST: creation, currents, reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from nrp_core.brain import FloatArray, IntArray, Network, ParameterChange, Population, no_variable
from nrp_core.errors import CapabilityError, NetworkError, did_you_mean
from nrp_core.network.cells import settled_gates

from nrp_brain_nest.cell_types import CELL_TYPES, MILLI, CellType


class Cells:
    """All cells that are not sources.

    Args:
        nest: the module, with an empty kernel.
        network: the network.

    Attributes:
        nodes: NEST's id of each global id, 0 for source cells, shape ``(network.size,)``.

    Raises:
        NetworkError: NEST refuses a parameter.
    """

    def __init__(self, nest: Any, network: Network) -> None:
        self._network = network
        self.nodes = np.zeros(network.size, np.int64)
        self._nest = nest
        self._collections: dict[str, Any] = {}
        self._parameters: dict[str, Mapping[str, FloatArray]] = {}
        self._offsets_pa = np.zeros(network.size)
        for population in network.populations.values():
            if population.size and not population.is_source:
                self._add(population, _created(nest, population))
        self._held_pa = self._offsets_pa.copy()

    def _add(self, population: Population, collection: Any) -> None:
        ids = self._network.ids_of(population.label)
        self.nodes[ids] = collection.tolist()
        self._collections[population.label] = collection
        self._parameters[population.label] = population.parameters
        self._offsets_pa[ids] = population.parameters["i_offset"] * MILLI

    def set_currents(self, currents_na: FloatArray) -> None:
        """Set constant currents, shape ``(network.size,)``, in addition to the cells' own."""
        wanted = self._offsets_pa + currents_na * MILLI
        changed = np.flatnonzero((wanted != self._held_pa) & (self.nodes > 0))
        for _, collection, index, which in self._by_population(changed):
            collection[index.tolist()].set(I_e=wanted[changed[which]].tolist())
        self._held_pa = wanted

    def changed(self, change: ParameterChange) -> Mapping[str, FloatArray]:
        """Return all parameters of a population after a change, in PyNN's units."""
        values = {name: array.copy() for name, array in self._parameters[change.label].items()}
        for name, array in change.values.items():
            values[name][change.index] = array
        return values

    def set_parameters(self, change: ParameterChange) -> None:
        """Change parameters of cells.

        Raises:
            NetworkError: NEST refuses a parameter.
        """
        population, now = self._network.populations[change.label], self.changed(change)
        cells = np.unique(change.index)
        ids = self._network.offsets[change.label] + cells
        chosen = {name: array[cells] for name, array in now.items()}
        part = replace(population, size=cells.size, parameters=chosen, initial_values={}, positions_um=None)
        values = nest_parameters(part, CELL_TYPES[population.cell_type])
        offsets_pa = values["I_e"]
        held_pa = self._held_pa[ids] - self._offsets_pa[ids] + offsets_pa
        collection = self._collections[change.label][cells.tolist()]
        _set(self._nest, collection, values | {"I_e": held_pa}, population)
        self._parameters[change.label] = now
        self._offsets_pa[ids], self._held_pa[ids] = offsets_pa, held_pa

    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        """Return a state variable in PyNN's unit.

        Raises:
            CapabilityError: one of the cells does not have it.
        """
        values = np.empty(len(neurons))
        for population, collection, index, which in self._by_population(neurons):
            kind = CELL_TYPES[population.cell_type]
            if variable not in kind.readable:
                raise no_variable(population.label, variable, kind.readable)
            name, factor = kind.state[variable]
            distinct, where = np.unique(index, return_inverse=True)
            held = np.atleast_1d(np.asarray(collection[distinct.tolist()].get(name), dtype=float))
            values[which] = held[where] / factor
        return values

    def set_trace_time(self, label: str, cells: IntArray, tau_minus_ms: FloatArray) -> None:
        """Set the time constant of the trace of cells' own spikes for STDP."""
        self._collections[label][cells.tolist()].set(tau_minus=tau_minus_ms.tolist())

    def _by_population(self, neurons: IntArray) -> Iterator[tuple[Population, Any, IntArray, IntArray]]:
        """Yield each population of the neurons, its cells, the indices in it and those in ``neurons``."""
        for label, collection in self._collections.items():
            population, first = self._network.populations[label], self._network.offsets[label]
            which = np.flatnonzero((neurons >= first) & (neurons < first + population.size))
            if which.size:
                yield population, collection, neurons[which] - first, which


def _created(nest: Any, population: Population) -> Any:
    kind = CELL_TYPES[population.cell_type]
    values = nest_parameters(population, kind) | _initial_state(population, kind)
    collection = nest.Create(kind.model, population.size)
    collection.set(dict(kind.fixed))
    _set(nest, collection, values, population)
    return collection


def _set(nest: Any, collection: Any, values: Mapping[str, FloatArray], population: Population) -> None:
    try:
        collection.set({name: array.tolist() for name, array in values.items()})
    except nest.NESTError as error:
        reason = str(error).rpartition(": ")[2] or str(error)
        raise NetworkError(
            f"population '{population.label}' ({population.cell_type}): "
            f"NEST's {CELL_TYPES[population.cell_type].model} refuses its parameters: {reason}"
        ) from error


def nest_parameters(population: Population, kind: CellType) -> dict[str, FloatArray]:
    """Return NEST's parameters of a population, in NEST's units.

    Raises:
        NetworkError: a parameter is missing or unknown.
    """
    where = f"population '{population.label}' ({population.cell_type})"
    given = population.parameters
    for name in given:
        if name not in kind.parameters:
            raise NetworkError(f"{where} has no parameter '{name}'{did_you_mean(name, kind.parameters)}")
    for name in kind.parameters:
        if name not in given:
            raise NetworkError(f"{where} needs the parameter '{name}'")
    values = {name: given[pynn] * factor for pynn, (name, factor) in kind.parameters.items()}
    if "tau_m" in given and "g_L" in values:
        values["g_L"] = given["cm"] / given["tau_m"] * MILLI
    return values


def _initial_state(population: Population, kind: CellType) -> dict[str, FloatArray]:
    given: Mapping[str, FloatArray] = {
        name: np.full(population.size, value) for name, value in kind.initial.items()
    } | dict(population.initial_values)
    if population.cell_type == "HH_cond_exp":
        given = settled_gates(given["v"] - population.parameters["v_offset"]) | dict(given)
    state = {}
    for name, values in given.items():
        if name in kind.state:
            nest_name, factor = kind.state[name]
            state[nest_name] = values * factor
        elif values.any():
            raise CapabilityError(
                f"population '{population.label}': NEST's {kind.model} cannot start with "
                f"{name} = {values[values != 0][0]:g}{did_you_mean(name, kind.state)}"
            )
    return state
