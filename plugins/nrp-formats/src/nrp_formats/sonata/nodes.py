"""SONATA's populations of nodes as populations of cells, and the input spikes of virtual ones."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import FloatArray, IntArray, Population
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.cells import CELLS
from nrp_core.network.files.hdf5 import attribute, column, group, groups, reading
from nrp_core.network.nest_models import LEAK_NS, NEST_CELLS, CellModel, NestParameter
from nrp_formats.sonata.attribute_checks import require_places
from nrp_formats.sonata.items import SonataItems

Trains = Mapping[int, FloatArray]
"""Spike times, ms, by node id."""

_MILLISECONDS: Final = ("ms", "milliseconds", "millisecond")


def read_spikes(files: Iterable[tuple[Path, str]]) -> dict[str, Trains]:
    """Return the spikes of virtual nodes by the name of their population.

    Args:
        files: each file, and the population of its nodes if the file has none: in the first layout of SONATA,
            ``/spikes/gids`` and ``/spikes/timestamps``.

    Raises:
        NetworkError: a file cannot be read, or its times are not in ms.
    """
    found: dict[str, dict[int, FloatArray]] = {}
    for path, population in files:
        with reading(path) as file:
            whole = group(file, "spikes")
            is_first = "gids" in whole and "timestamps" in whole
            for name, part in [(population, whole)] if is_first else groups(whole):
                _require_ms(part, name)
                times = column(part, "timestamps", float)
                ids = column(part, "gids" if is_first else "node_ids", np.int64)
                if len(times) != len(ids):
                    raise NetworkError(f"spikes of '{name}': {len(times)} timestamps, {len(ids)} node_ids")
                order = np.lexsort((times, ids))
                numbers, starts = np.unique(ids[order], return_index=True)
                trains = np.split(times[order], starts[1:])
                found.setdefault(name, {}).update(zip(numbers.tolist(), trains, strict=True))
    return dict(found)


def _require_ms(part: Any, name: str) -> None:
    times = part.get("timestamps")
    if times is None or "units" not in times.attrs:
        return
    unit = attribute(times, "units", str)
    if unit not in _MILLISECONDS:
        raise NetworkError(f"the timestamps of '{name}' are in '{unit}'; only 'ms' is read")


_PYNN = {name: CellModel(name, {}) for name in CELLS}
_SCHEMAS: Mapping[str, Mapping[str, CellModel]] = {"pynn": _PYNN, "nest": NEST_CELLS}


def model_of(owner: str, model_type: str, template: str) -> CellModel:
    """Return the model of a type of point neurons.

    Args:
        owner: the owner of the model, for the message.
        model_type: SONATA's model type.
        template: ``schema:resource``.

    Raises:
        CapabilityError: the model is not supported; the message names the nearest.
    """
    schema, _, resource = template.partition(":")
    if model_type not in ("point_neuron", "point_process"):
        raise CapabilityError(
            f"{owner} is of model_type '{model_type}'; supported are point_neuron and virtual, and "
            "the nearest cell with channels is pynn:HH_cond_exp"
        )
    models = _SCHEMAS.get(schema.lower())
    if models is None:
        choices = [f"{known}:{name}" for known, names in _SCHEMAS.items() for name in names]
        nearest = difflib.get_close_matches(template, choices, 1, 0.0)[0]
        raise CapabilityError(
            f"{owner} is of model '{template}', which is not supported; "
            f"the nearest supported model: {nearest}"
        )
    if resource not in models:
        nearest = f"{schema}:{difflib.get_close_matches(resource, list(models), 1, 0.0)[0]}"
        nearest = "pynn:HH_cond_exp" if resource.startswith(("hh_", "HH_")) else nearest
        raise CapabilityError(
            f"{owner} is of model '{template}', which is not supported; "
            f"the nearest supported model: {nearest}"
        )
    return models[resource]


VIRTUAL = "virtual"
_POISSON = CellModel("SpikeSourcePoisson", {})
_ARRAY = CellModel("SpikeSourceArray", {})


@dataclass(frozen=True)
class Nodes:
    """One population of nodes.

    Args:
        items: the nodes.
        node_ids: their ids, to which edges refer.
        models: each resulting cell population's model, with its nodes.
        populations: the cells; a node's index within its population is its place in the nodes of the model.
    """

    items: SonataItems
    node_ids: IntArray
    models: tuple[tuple[CellModel, IntArray], ...]
    populations: tuple[Population, ...]

    def places_of(self, node_ids: IntArray, edges: str) -> IntArray:
        """Return the places of the nodes with these ids.

        Raises:
            NetworkError: a node does not exist; the message names the edges that refer to it.
        """
        if not len(self.node_ids):
            raise NetworkError(f"edges '{edges}' refer to nodes '{self.items.name}', which are none")
        order = np.argsort(self.node_ids, kind="stable")
        ordered = self.node_ids[order]
        at = np.minimum(np.searchsorted(ordered, node_ids), len(ordered) - 1)
        wrong = ordered[at] != node_ids
        if wrong.any():
            raise NetworkError(
                f"edges '{edges}' refer to node {node_ids[np.argmax(wrong)]}, which nodes "
                f"'{self.items.name}' do not have"
            )
        return order[at]


def read_nodes(part: Any, items: SonataItems, spikes: Trains) -> Nodes:
    """Make the cells of a population of nodes.

    Args:
        part: its HDF5 group.
        items: the nodes.
        spikes: spike times of virtual nodes, ms, by node id.

    Raises:
        NetworkError: a parameter is invalid.
        CapabilityError: the cell model is not supported.
    """
    node_ids = column(part, "node_id", np.int64) if "node_id" in part else np.arange(len(items))
    if len(node_ids) != len(items):
        raise NetworkError(
            f"nodes '{items.name}' are {len(items)}, and {len(node_ids)} of them have a node_id"
        )
    require_places(items, node_ids)
    models = tuple(_models(items))
    several = len(models) > 1
    populations = tuple(
        _population(f"{items.name}/{model.cell_type}" if several else items.name, model, items, chosen,
                    [spikes.get(int(node), np.empty(0)) for node in node_ids[chosen]]
                    if model is _ARRAY else ())
        for model, chosen in models
    )  # fmt: skip
    return Nodes(items, node_ids, models, populations)


def _models(items: SonataItems) -> Iterator[tuple[CellModel, IntArray]]:
    """Yield each cell model among nodes with its nodes, in order of first appearance."""
    kinds, templates = items.texts("model_type"), items.texts("model_template")
    chosen: dict[str, tuple[CellModel, list[int]]] = {}
    is_random = ~np.isnan(items.numbers("rate"))
    for number, kind in kinds.items():
        if kind == VIRTUAL:
            random = bool(is_random[items.type_ids == number].any())
            model = _POISSON if random else _ARRAY
        else:
            model = model_of(f"node type {number} of '{items.name}'", kind, templates[number])
        chosen.setdefault(f"{model.cell_type} {model.leaks}", (model, []))[1].append(number)
    for model, numbers in chosen.values():
        yield model, np.flatnonzero(np.isin(items.type_ids, numbers))


def _population(
    label: str, model: CellModel, items: SonataItems, chosen: IntArray, trains: Sequence[FloatArray]
) -> Population:
    cell = CELLS[model.cell_type]
    parameters = {
        name: _values(name, model, items, chosen, known.default) for name, known in cell.parameters.items()
    }
    initial = {name: np.full(len(chosen), known.default) for name, known in cell.state.items()}
    for name, source in model.initial.items():
        initial[name] = _given(source, items, chosen)
    for name, only in model.fixed.items():
        given = items.numbers(name)[chosen]
        if (given[~np.isnan(given)] != only).any():
            raise CapabilityError(
                f"nodes '{items.name}': {name} of {model.cell_type} cells can only be {only:g}"
            )
    return Population(
        label=label, size=len(chosen), cell_type=model.cell_type, parameters=parameters,
        initial_values=initial, spike_times_ms=tuple(trains), positions_um=_positions(items, chosen),
    )  # fmt: skip


def _values(name: str, model: CellModel, items: SonataItems, chosen: IntArray, default: float) -> FloatArray:
    source = model.parameters.get(name, NestParameter(name, 1.0, default))
    if source.name == "tau_m" and model.leaks:
        leak = items.numbers("g_L")[chosen]
        leaky = _leak_ns(items, chosen)
        if leaky is not None:  # C_m / g_L is in pF / nS, which is ms
            leak = np.where(np.isnan(leak), leaky, leak)
            return _values("cm", model, items, chosen, np.nan) * 1000 / leak
    return _given(source, items, chosen)


def _given(source: NestParameter, items: SonataItems, chosen: IntArray) -> FloatArray:
    values = items.numbers(source.name)[chosen]
    return np.ascontiguousarray(np.where(np.isnan(values), source.default, values) * source.scale)


def _leak_ns(items: SonataItems, chosen: IntArray) -> FloatArray | None:
    """Return the default leak of each node's model; None for models with a membrane time constant."""
    templates = items.texts("model_template")
    by_type = {number: LEAK_NS.get(text.partition(":")[2]) for number, text in templates.items()}
    found = [by_type[number] for number in items.type_ids[chosen].tolist()]
    return None if None in found else np.array(found, dtype=float)


def _positions(items: SonataItems, chosen: IntArray) -> FloatArray | None:
    columns = [items.numbers(axis)[chosen] for axis in "xyz"]
    if np.isnan(columns[0]).any():
        return None
    return np.nan_to_num(np.stack(columns, axis=1))
