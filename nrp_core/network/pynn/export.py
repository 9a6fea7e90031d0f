"""Converts the objects that a script built to a network: same numbers and units, nothing is drawn again."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import count, product, repeat
from typing import Any

import numpy as np
from pyNN.common import Assembly, BasePopulation
from pyNN.random import RandomDistribution

from nrp_core._support.arrays import FloatArray, IndexArray, IntArray
from nrp_core.clock import nanoseconds
from nrp_core.errors import NetworkError
from nrp_core.network import data as data
from nrp_core.network.currents import InjectedCurrent
from nrp_core.network.data import Network, Origin
from nrp_core.network.equations.model import INPUT, known_value
from nrp_core.network.indices import indices_of
from nrp_core.network.picking import CIRCUIT, Selection, find_shadowed, select_neurons
from nrp_core.network.pynn.arguments import InvalidValueError
from nrp_core.network.pynn.populations import SPIKE_TIMES, Population, ids_of, parts_of, require_existing
from nrp_core.network.pynn.projections import Projection
from nrp_core.network.pynn.simulator import State
from nrp_core.network.pynn.synapse_columns import constant, taken
from nrp_core.network.rewiring import Rewiring


def rewirings_of(projections: Iterable[Any], labels: Mapping[Any, str]) -> dict[int, Rewiring]:
    """Return how synapses of each type that form and vanish do so, by the identity of the type.

    A target follows the last mechanism that was given to it, as in sPyNNaker 7.4.1.

    Args:
        projections: the projections of a script, in order.
        labels: its populations and their labels, in order.
    """
    rewired = [one for one in projections if hasattr(one.synapse_type, "rewiring")]
    last = {one.post: one.synapse_type for one in rewired}
    targets: dict[int, list[str]] = {}
    for population, label in labels.items():
        if population in last:
            targets.setdefault(id(last[population]), []).append(label)
    found = {id(one.synapse_type): one.synapse_type.rewiring for one in rewired}
    several = {key: labels[0] for key, labels in targets.items() if len(labels) > 1}
    seeded = {key: label for key, label in several.items() if found[key].seed is not None}
    return found | {key: replace(found[key], stream=label) for key, label in seeded.items()}


def views_of(
    variables: Mapping[str, Any], populations: Mapping[str, Selection], state: State
) -> dict[str, IntArray]:
    """Return the global ids of all named neurons.

    Args:
        variables: the script's variables.
        populations: selections of cells of the variable ``circuit``, by name.
        state: the objects built by the script.

    Raises:
        NetworkError: the script has no circuit to select from, or it no longer exists.
        NeuronSelectionError: the circuit has no such cells.
    """
    circuit = variables.get(CIRCUIT)
    named = {name: cells for name, cells in variables.items() if _is_cells(cells) and name[0] != "_"}
    if isinstance(circuit, Mapping):
        named |= {str(label): cells for label, cells in circuit.items() if _is_cells(cells)}
    views = {name: _existing_ids(name, cells, state) for name, cells in named.items()}
    if populations and not _is_cells(circuit):
        raise NetworkError(
            f"the script has no circuit from which to take '{next(iter(populations))}': name a population, "
            f"view or assembly '{CIRCUIT}', or use the names that there are ({', '.join(named) or 'none'})"
        )
    chosen = {
        name: select_neurons(name, selection, views[CIRCUIT]) for name, selection in populations.items()
    }
    labels = {one.label: ids_of(one) for one in state.populations}
    for text in find_shadowed({**labels, **views}, chosen):
        state.remark(text)
    return views | chosen


def _is_cells(value: object) -> bool:
    return isinstance(value, (BasePopulation, Assembly))


def _existing_ids(name: str, cells: Any, state: State) -> IntArray:
    require_existing(name, cells, state)
    return ids_of(cells)


def network_of(state: State, views: Mapping[str, IntArray] | None = None) -> Network:
    """Return everything built so far as a network.

    A number is appended to a label that the script uses twice.

    Args:
        state: the objects that the script built.
        views: named neurons, as global ids.

    Raises:
        NetworkError: the network is inconsistent.
    """
    labels = dict(zip(state.populations, unique(p.label for p in state.populations), strict=True))
    constant_na, currents = _injected(state)
    populations = {label: _population(p, label, constant_na[ids_of(p)]) for p, label in labels.items()}
    names = unique(projection.label for projection in state.projections)
    rewirings = rewirings_of(state.projections, labels)
    parts = map(_parts, state.projections, names, repeat(labels), repeat(rewirings))
    projections = tuple(part for several in parts for part in several)
    renamed = (
        *_renamed_populations(state.populations, list(labels.values())),
        *_renamed_projections(state.projections, names),
    )
    remarks = (*state.remarks, *renamed)
    return Network(
        populations, projections, dict(views or {}), timestep_ms=state.dt, remarks=remarks, currents=currents
    )


def _renamed_populations(populations: Iterable[Population], labels: Iterable[str]) -> Iterator[str]:
    for one, label in zip(populations, labels, strict=True):
        if one.label != label:
            yield f"two populations have the label '{one.label}'; the later one is called '{label}'"


def _renamed_projections(projections: Iterable[Projection], labels: Iterable[str]) -> Iterator[str]:
    """Yield labels that two projections between the same populations share.

    Projections between different populations may share a label. A projection without one is named after its
    populations.
    """
    seen: set[tuple[str, bytes, bytes]] = set()
    for one, label in zip(projections, labels, strict=True):
        if not one.has_own_label:
            continue
        key = (one.label, ids_of(one.pre).tobytes(), ids_of(one.post).tobytes())
        if key in seen:
            yield (
                f"two projections from '{one.pre.label}' to '{one.post.label}' have the label '{one.label}'; "
                f"the later one is called '{label}'"
            )
        seen.add(key)


def unique(names: Iterable[str]) -> list[str]:
    """Return names with a number added to those that came before: ``a``, ``a 2``, ``a 3``."""
    taken_names: list[str] = []
    for name in names:
        candidates = (name if i == 1 else f"{name} {i}" for i in count(1))
        taken_names.append(next(candidate for candidate in candidates if candidate not in taken_names))
    return taken_names


def _injected(state: State) -> tuple[FloatArray, tuple[InjectedCurrent, ...]]:
    """Return the constant current from sources into each cell, nA, and the currents that change."""
    constant_na, currents = np.zeros(state.n_cells), []
    for injection in state.injections:
        times_ms, amplitudes_na = injection.source.steps()
        if nanoseconds(times_ms).tolist() == [0]:
            np.add.at(constant_na, injection.cells, amplitudes_na[0])
        else:
            currents.append(InjectedCurrent(injection.cells, times_ms, amplitudes_na))
    return constant_na, tuple(currents)


def _population(population: Population, label: str, current_na: FloatArray) -> data.Population:
    parameters = {name: array.copy() for name, array in population.parameter_arrays.items()}
    trains = parameters.pop(SPIKE_TIMES, ())
    if current_na.any():
        parameters[INPUT] += current_na * getattr(population.celltype, "input_per_na", 1.0)
    return data.Population(
        label=label,
        size=population.size,
        cell_type=cell_type_of(population),
        parameters=parameters,
        initial_values=_beginnings(population, label, parameters),
        spike_times_ms=tuple(np.asarray(train.value, dtype=float) for train in trains),
        positions_um=np.ascontiguousarray(population.places) if population.has_space else None,
        hints=dict(population.hints),
        equations=getattr(population.celltype, "equations", None),
    )


def _beginnings(population: Population, label: str, parameters: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return the initial values of state variables.

    Raises:
        InvalidValueError: the script set a value that contradicts the equations of the cells.
    """
    kind, values = population.celltype, population.initial_arrays
    equations = getattr(kind, "equations", None)
    if equations is None:
        return {name: array.copy() for name, array in values.items()}
    model = equations.model
    kept = {name: array.copy() for name, array in values.items() if name in model.variables}
    state = dict.fromkeys(model.variables, 0.0) | equations.state_at_start(parameters, kept)
    for name in values.keys() - kept.keys():
        follows = known_value(model.definitions[name], state, model.definitions) / model.recorded[name].scale
        own = (values[name] != kind.default_initial_values[name]) & ~np.isclose(values[name], follows)
        if own.any():
            raise InvalidValueError(
                f"population '{label}': {name} follows from the equations of {type(kind).__name__}: "
                f"it begins at {np.broadcast_to(follows, own.shape)[own][0]:g}, "
                f"not at {values[name][own][0]:g}"
            )
    return kept


def cell_type_of(population: Population) -> str:
    """Return the name of a population's cell type in a network; a script may use another name."""
    return str(getattr(population.celltype, "cell_type", type(population.celltype).__name__))


def _parts(
    projection: Projection, name: str, labels: Mapping[Population, str], rewirings: Mapping[int, Rewiring]
) -> Iterator[data.Projection]:
    """Return a projection as one to each receptor between each pair of populations that its ends cover."""
    sources, targets = _members(projection.pre), _members(projection.post)
    several = len(sources) > 1 or len(targets) > 1
    routes = list(projection.routes())
    for (pre, from_cells), (post, to_cells), (receptor, sign, of_receptor) in product(
        sources, targets, routes
    ):
        chosen: Any = slice(None) if of_receptor is None else of_receptor
        if several:
            between = (from_cells[projection.pre_index] >= 0) & (to_cells[projection.post_index] >= 0)
            chosen = between if of_receptor is None else between & of_receptor
        values = {key: taken(column, chosen) for key, column in projection.values.items()}
        (n,) = values["weight"].shape
        if sign < 0:
            values["weight"] = -values["weight"]
        part = f"{name} ({labels[pre]}→{labels[post]})" if several else name
        yield data.Projection(
            label=part if receptor == projection.receptor_type else f"{part} ({receptor})",
            pre=labels[pre],
            post=labels[post],
            receptor=receptor,
            pre_index=_within(from_cells, projection, "pre", chosen),
            post_index=_within(to_cells, projection, "post", chosen),
            weight=values.pop("weight"),
            delay_ms=values.pop("delay", constant(0.0, n)),
            synapse_type=projection.synapse_type.kind,
            synapse_parameters=values,
            plasticity=projection.synapse_type.plasticity,
            origin=_origin(projection),
            equations=getattr(projection.synapse_type, "equations", None),
            initial_values={key: column[chosen] for key, column in projection.initial_state.items()},
            rewiring=rewirings.get(id(projection.synapse_type)),
            neuromodulation=getattr(projection.synapse_type, "neuromodulation", None),
        )


def _within(places: IndexArray, projection: Projection, end: str, chosen: Any) -> Any:
    """Return an array at selected cells; for a whole population, the stored array itself."""
    if isinstance(getattr(projection, end), Population) and isinstance(chosen, slice):
        return indices_of(projection, f"{end}_index")
    return places[getattr(projection, f"{end}_index")[chosen]]


def _members(cells: Any) -> list[tuple[Population, IndexArray]]:
    """Return each population among the cells, with the index of every cell in it, or -1."""
    owners = dict.fromkeys(part._owner() for part in parts_of(cells))
    ids = ids_of(cells)
    members = []
    for owner in owners:
        first = int(owner.first_id)
        inside = (ids >= first) & (ids < first + owner.size)
        members.append((owner, np.where(inside, ids - first, -1).astype(np.int32)))
    return members


def _origin(projection: Projection) -> Origin:
    connector = projection.connector
    parameters = {key: described(value) for key, value in connector.get_parameters().items()}
    weight, delay = (described(projection.given[key]) for key in ("weight", "delay"))
    return Origin(type(connector).__name__, parameters, weight, delay)


def described(value: Any) -> Any:
    """Return a parameter as a number, a flag or a text that is the same in every run; arrays as None."""
    if isinstance(value, np.generic):  # first, as some of these are Python numbers too
        return value.item()
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, RandomDistribution):
        return f"{value.name}({', '.join(f'{key}={number}' for key, number in value.parameters.items())})"
    if value is None or isinstance(value, (list, tuple, np.ndarray)):
        return None
    return getattr(value, "label", None) or getattr(value, "__name__", type(value).__name__)
