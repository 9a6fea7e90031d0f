"""The synapses of a network as tables of the grid: two bytes each where weights and delays are equal.

A table takes all projections whose synapses act on the same variable of the same 65536 neurons in the
same way. Individual weights are in single precision; delays are given by the stretch of a synapse. A
stretch is shorter than a line of memory in many networks, so the tables of static synapses with weights of
their own are contiguous: one read covers all targets of a spike after one delay.

Convert cells to runs: the coefficients of neurons' updates by a step, and their initial state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import e, prod
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from nrp_brain_event.connections import fill_short_term, is_share, numbers_of, places_of_plastic
from nrp_brain_event.grid import sorting
from nrp_brain_event.grid.records import (
    CONDUCTANCE,
    CURRENT,
    CURVED,
    EQUATIONS,
    JUMP,
    N_STATE,
    PLASTIC,
    SHORT_TERM,
    Run,
    S,
    Segment,
    Table,
    V,
    X,
)
from nrp_brain_event.records import ALPHA, FROZEN, LINEAR, Array, ShortTerm
from nrp_brain_event.records import CONDUCTANCE as CONDUCTANCE_MEMBRANE
from nrp_brain_event.records import EQUATIONS as OWN_EQUATIONS
from nrp_brain_event.records import JUMP as JUMP_SYNAPSE
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.network.data import Network, Projection
from nrp_core.network.drawing import extremes
from nrp_core.network.filters import driven
from nrp_core.network.grid import Grid as TimeGrid
from nrp_core.network.indices import stored_form
from nrp_core.network.limits import distinct

_DECIDING: Final = (
    "membrane", "synapse", "v_rest", "v_reset", "v_thresh", "tau_m", "cm", "tau_refrac", "tau_syn",
    "e_rev_E", "e_rev_I",
)  # fmt: skip
"""Fields that are equal for all cells of a run."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def kind_of(cell: Any) -> int:
    """Return the kind of update of a ``Cell``."""
    if cell["membrane"] == LINEAR:
        return JUMP if cell["synapse"] == JUMP_SYNAPSE else CURRENT
    if cell["membrane"] == OWN_EQUATIONS:
        return EQUATIONS
    return CONDUCTANCE if cell["membrane"] == CONDUCTANCE_MEMBRANE else CURVED


def line_of(cell: Any, receptor: int) -> int:
    """Return the row of the state on which spikes act that arrive at a receptor of a ``Cell``."""
    kind = kind_of(cell)
    if kind == JUMP:
        return X
    return receptor + (S if kind != CURVED and cell["synapse"] == ALPHA else X)


def load_runs(cells: Array, h: float) -> Array:
    """Return the ``Run`` records of cells, for steps of h ms."""
    columns = [cells[name].reshape(len(cells), prod(cells[name].shape[1:])) for name in _DECIDING]
    deciding = np.concatenate(columns, axis=1)
    own = ~np.isin(cells["membrane"], (LINEAR, CONDUCTANCE_MEMBRANE))
    deciding[own, 1:] = 0.0  # integrated one by one, or by a kernel of their population
    begins = np.append(True, (deciding[1:] != deciding[:-1]).any(axis=1))[: len(cells)]
    firsts = np.flatnonzero(begins)
    runs = np.zeros(len(firsts), Run.dtype())
    runs["first"], runs["last"] = firsts, np.append(firsts[1:], len(cells))
    for run in runs:
        cell = cells[run["first"]]
        run["kind"] = kind_of(cell)
        if run["kind"] not in (CURVED, EQUATIONS):
            _derive(run, cell, h)
    return runs


def load_state(cells: Array) -> FloatArray:
    """Return the initial state of cells."""
    state = np.zeros((N_STATE, len(cells)))
    held = np.isin(cells["membrane"], (LINEAR, CONDUCTANCE_MEMBRANE))
    state[V] = np.where(held, cells["path"][:, 0, 0] - cells["v_rest"], 0.0)
    state[X : X + 2] = np.where(held, cells["x"].T, 0.0)
    return state


def input_lines(runs: Array, state: FloatArray) -> IntArray:
    """Return the index into the flattened state on which inputs act, for both receptors and each row."""
    rows, lengths = np.arange(state.shape[1]), runs["last"] - runs["first"]
    jumps = runs["kind"] == JUMP
    grown = ((runs["kind"] == CURRENT) | (runs["kind"] == CONDUCTANCE)) & (runs["alpha"] == 1)
    lines = [np.where(jumps, X, np.where(grown, S, X) + receptor) for receptor in range(2)]
    return np.stack([np.repeat(line, lengths) * len(rows) + rows for line in lines])


def _derive(run: Any, cell: Any, h: float) -> None:
    run["alpha"] = cell["synapse"] == ALPHA
    run["v_rest"] = cell["v_rest"]
    run["reset"], run["threshold"] = cell["v_reset"] - cell["v_rest"], cell["v_thresh"] - cell["v_rest"]
    run["refractory"] = np.ceil(cell["tau_refrac"] / h - 1e-6)
    run["frozen"] = cell["synapse"] == FROZEN
    if run["frozen"]:  # as in Brian2, the step in which the period ends counts
        run["refractory"] = max(run["refractory"] - 1, 0)
    run["reversal"] = cell["e_rev_E"] - cell["v_rest"], cell["e_rev_I"] - cell["v_rest"]
    run["kept"] = np.exp(-h / cell["tau_syn"])
    run["grown"] = e * h / cell["tau_syn"]
    if run["kind"] == CONDUCTANCE:
        run["leak"], run["gain"] = h / cell["tau_m"], h / cell["cm"]
        _derive_moments(run, cell, h)
        return
    run["leak"] = np.exp(-h / cell["tau_m"])
    run["gain"] = -np.expm1(-h / cell["tau_m"]) * cell["tau_m"] / cell["cm"]
    for k, tau in enumerate(cell["tau_syn"].tolist()):
        leak, kept, gap = float(run["leak"]), float(run["kept"][k]), 1.0 / tau - 1.0 / float(cell["tau_m"])
        unit = float(cell["tau_m"] if run["frozen"] else cell["cm"])
        run["x_effect"][k] = driven(h, leak, kept, gap, 1.0, 0.0) / unit
        run["s_effect"][k] = driven(h, leak, kept, gap, 0.0, e / tau) / unit


def _derive_moments(run: Any, cell: Any, h: float) -> None:
    """Integrate the course of both synapses over a step by Gauss-Legendre quadrature."""
    u, weights = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS * run["gain"]
    for k, tau in enumerate(cell["tau_syn"].tolist()):
        x = weights * np.exp(-u * h / tau)
        s = x * u * run["grown"][k]
        run["x_effect"][k], run["s_effect"][k] = x.sum(), s.sum()
        run["x_moment"][k], run["s_moment"][k] = (x * (u - 0.5)).sum(), (s * (u - 0.5)).sum()


_SPAN: Final = 1 << 16


@dataclass(frozen=True)
class ProjectionPart:
    """The synapses of a projection onto one span of rows.

    Args:
        projection: the projection; sorted if its synapses have states.
        pre_first, post_first: global id and row of the first cells.
        line: row of the state that the synapses act on.
        span: number of the span.
        weight: weight of all synapses, or None if each has its own.
        dynamic: ``SHORT_TERM``, ``PLASTIC``, or 0.
        dynamics: states of dynamic synapses: ``ShortTerm``, or rows of plastic synapses.
        is_alone: whether no other projection is in the same table.
    """

    projection: Projection
    pre_first: int
    post_first: int
    line: int
    span: int
    weight: float | None
    dynamic: int = 0
    dynamics: Array | None = None
    is_alone: bool = False

    @property
    def key(self) -> tuple[object, ...]:
        """The common properties of the parts of a table."""
        alone = self.projection.label if self.is_alone else None
        return self.line, self.span, self.weight, alone

    @property
    def bounds(self) -> tuple[int, int]:
        """The postsynaptic indices in the span."""
        low = self.span * _SPAN - self.post_first
        return low, low + _SPAN


Store = dict[int, list[ProjectionPart]]
"""The parts of the tables that lie together, by the number of the table."""


@dataclass(frozen=True)
class Segments:
    """Stretches of equal delay and table."""

    neuron: Array
    start: Array
    length: Array
    delay: Array
    """Steps."""
    table: Array


def load_tables(
    network: Network,
    cells: Array,
    row_of: IntArray,
    grid: TimeGrid,
    without: frozenset[str],
    weights_now: Mapping[str, FloatArray] = MappingProxyType({}),
    each: frozenset[str] = frozenset(),
) -> dict[str, Array]:
    """Return the parts of the :class:`~nrp_brain_event.grid.records.Grid` that hold synapses, by name.

    Args:
        network: the network.
        cells: its ``Cell`` records.
        row_of: their rows by global id.
        grid: the grid of times.
        without: labels of projections that are simulated in another way.
        weights_now: changed weights of projections, by label. Of those that are all equal, the table has no
            other projection.
        each: labels of the projections whose synapses have weights of their own even if these are equal.

    Raises:
        NetworkError: a parameter of plasticity is missing.
    """
    groups: dict[tuple[object, ...], list[ProjectionPart]] = {}
    plastic_rows = places_of_plastic(network, row_of)[1]
    for projection in network.projections:
        if projection.size and projection.label not in without and not projection.is_continuous:
            given = weights_now.get(projection.label)
            now = projection if given is None else replace(projection, weight=given)
            for part in _parts(network, now, cells, row_of, grid, plastic_rows):
                if part.dynamic or (given is not None and part.weight is not None):
                    part = replace(part, is_alone=True)
                if part.projection.label in each:
                    part = replace(part, weight=None, is_alone=bool(part.dynamic))
                groups.setdefault(part.key, []).append(part)
    stores = _stores(list(groups.values()))
    firsts = [np.append(0, np.cumsum(_count(network, _parts_in(store)))) for store in stores]
    owns = [_has_own(_parts_in(store)[0]) for store in stores]
    n_all = sum(int(first[-1]) for first in firsts)
    n_own = sum(int(first[-1]) for first, own in zip(firsts, owns, strict=True) if own)
    targets, weights = np.empty(n_all, np.uint16), np.empty(n_own, np.float32)
    tables, segments = np.zeros(len(groups), Table.dtype()), []
    dynamics = {SHORT_TERM: [np.empty(0, ShortTerm.dtype())], PLASTIC: [np.empty(0, np.int32)]}
    done = done_own = 0
    for first, store, own in zip(firsts, stores, owns, strict=True):
        n = int(first[-1])
        for number, (one, *_) in store.items():
            table = tables[number]
            table["line"] = one.line * len(cells) + one.span * _SPAN
            table["weight"], table["own"], table["dynamic"] = one.weight or 0.0, own, one.dynamic
            table["weights"] = done_own - done
            if one.dynamics is not None:
                before = dynamics[one.dynamic]
                table["dynamics"] = sum(map(len, before)) - done
                before.append(one.dynamics)
        found = _fill(store, first, targets[done : done + n], weights[done_own : done_own + n * own], grid)
        segments.append(replace(found, start=found.start + done))
        done, done_own = done + n, done_own + n * own
    return {
        "tables": tables, "targets": targets, "weights": weights,
        # without a compiler kernels read fields as attributes, which a joined array does not have
        "short_term": np.concatenate(dynamics[SHORT_TERM]).view(ShortTerm.dtype()),
        "plastic_rows": np.concatenate(dynamics[PLASTIC]), **_joined(segments, network.size),
    }  # fmt: skip


def _parts(
    network: Network, projection: Projection, cells: Array, row_of: IntArray, grid: TimeGrid,
    plastic_rows: Mapping[str, Array],
) -> Iterator[ProjectionPart]:  # fmt: skip
    post_first = int(row_of[network.offsets[projection.post]])
    targets = cells[post_first : post_first + network.populations[projection.post].size]
    line = line_of(targets[0], network.populations[projection.post].receptor_number(projection.receptor))
    weight, dynamic, dynamics = common(extremes(stored_form(projection, "weight"))), 0, None
    if is_share(projection) or projection.is_plastic:  # in the order of the table
        steps = grid.delays(projection.delay_ms)
        order = np.lexsort((projection.post_index, steps, projection.pre_index))
        numbers = numbers_of(projection)[order]
        weight, projection = None, projection.only(order)
        if projection.is_plastic:
            dynamic, dynamics = PLASTIC, plastic_rows[projection.label][order]
        else:
            table: Array = np.zeros(projection.size, ShortTerm.dtype())
            fill_short_term(table, projection, targets[projection.post_index], numbers)
            if projection.initial_values:  # the kernels see the times of arrivals
                table["t"] = steps[order] * grid.step_ms
            dynamic, dynamics = SHORT_TERM, table
    pre_first = network.offsets[projection.pre]
    spans = range(post_first // _SPAN, (post_first + len(targets) - 1) // _SPAN + 1)
    for span in spans:
        part = ProjectionPart(projection, pre_first, post_first, line, span, weight, dynamic, dynamics)
        if dynamics is not None and len(spans) > 1:
            low, high = part.bounds
            inside = (projection.post_index >= low) & (projection.post_index < high)
            part = replace(part, dynamics=dynamics[inside])
        yield part


def common(values: FloatArray) -> float | None:
    """Return the common value, or None."""
    kept = distinct(values)
    return float(kept[0]) if (kept == kept[0]).all() else None


def _stores(groups: list[list[ProjectionPart]]) -> list[Store]:
    """Return the tables that lie together, and each other one alone."""
    together: Store = {}
    alone: list[Store] = []
    for number, parts in enumerate(groups):
        if parts[0].weight is None and not parts[0].dynamic:
            together[number] = parts
        else:
            alone.append({number: parts})
    return [together, *alone] if together else alone


def _has_own(part: ProjectionPart) -> bool:
    """Return whether the table holds a weight for each synapse; plastic ones have theirs in records."""
    return part.weight is None and part.dynamic != PLASTIC


def _parts_in(store: Store) -> list[ProjectionPart]:
    return [part for parts in store.values() for part in parts]


def _count(network: Network, parts: list[ProjectionPart]) -> IntArray:
    """Return the number of synapses of a store from each neuron."""
    n = np.zeros(network.size, np.int64)
    for part in parts:
        for pre, post in part.projection.pairs():
            sorting.count(pre, post, *part.bounds, n[part.pre_first :])
    return n


def _fill(store: Store, first: IntArray, targets: Array, weights: Array, grid: TimeGrid) -> Segments:
    """Write the synapses of a store; ``first`` is the index of each neuron's first synapse."""
    at, parts, numbers = first[:-1].copy(), _parts_in(store), np.array([*store])
    for part in parts:
        shift = part.post_first - part.span * _SPAN
        for pre, post in part.projection.pairs():
            sorting.place(pre, post, *part.bounds, shift, at[part.pre_first :], targets)
    if len(weights):
        _place_values(parts, first, weights, lambda part: part.projection.weight, lambda _, given: given)
    delays_ms = [extremes(stored_form(part.projection, "delay_ms")) for part in parts]
    ends = grid.delays(np.array([(each.min(), each.max()) for each in delays_ms]))
    if ends.min() == ends.max() and not len(weights):
        sorting.sort_targets(first, targets)
        neuron = np.flatnonzero(np.diff(first))
        delay, table = np.full(len(neuron), ends.min()), np.full(len(neuron), numbers[0])
        return Segments(neuron, first[neuron], np.diff(first)[neuron], delay, table)
    place_of = {own[0].key: place for place, own in enumerate(store.values())}

    def key(part: ProjectionPart, delays_ms: Array) -> Array:
        return grid.delays(delays_ms) * len(store) + place_of[part.key]

    keys = np.empty(len(targets), np.uint16 if (ends.max() + 1) * len(store) < _SPAN else np.int64)
    _place_values(parts, first, keys, lambda part: part.projection.delay_ms, key)
    sorting.sort_by_key(first, keys, targets, weights)
    n = sorting.count_segments(first, keys)
    neuron, start = np.empty(n, np.int64), np.empty(n, np.int64)
    sorting.cut_segments(first, keys, neuron, start)
    delay, table = np.divmod(keys[start].astype(np.int64), len(store))
    return Segments(neuron, start, np.diff(np.append(start, len(targets))), delay, numbers[table])


def _place_values(
    parts: list[ProjectionPart], first: IntArray, out: Array,
    given: Callable[[ProjectionPart], Array], converted: Callable[[ProjectionPart, Array], Array],
) -> None:  # fmt: skip
    at = first[:-1].copy()
    for part in parts:
        each, begin = distinct(given(part)), 0
        for pre, post in part.projection.pairs():
            some = each[begin : begin + len(pre)] if len(each) == part.projection.size else each
            begin += len(pre)
            step, values = int(len(some) == len(pre)), np.ascontiguousarray(converted(part, some))
            sorting.place_values(pre, post, *part.bounds, values, step, at[part.pre_first :], out)


def _joined(segments: list[Segments], n_neurons: int) -> dict[str, Array]:
    """Return the segments of all tables in the order in which the spikes of each neuron pass them."""
    none = np.empty(0, np.int64)
    neuron = np.concatenate([none, *(part.neuron for part in segments)])
    delay = np.concatenate([none, *(part.delay for part in segments)])
    table = np.concatenate([none, *(part.table for part in segments)])
    order = np.lexsort((table, delay, neuron))
    neuron, delay = neuron[order], delay[order]
    begins = np.append(True, neuron[1:] != neuron[:-1])[: len(neuron)]
    gap = np.where(begins, delay, np.diff(delay, prepend=0))
    joined = np.zeros(len(neuron), Segment.dtype())
    joined["start"] = np.concatenate([none, *(part.start for part in segments)])[order]
    joined["length"] = np.concatenate([none, *(part.length for part in segments)])[order]
    joined["gap"], joined["table"] = gap, table[order]
    joined["last"] = np.append(begins[1:], True)[: len(neuron)]
    return {"row_first": np.searchsorted(neuron, np.arange(n_neurons + 1)), "segments": joined}
