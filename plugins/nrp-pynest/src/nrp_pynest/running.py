"""Calls of NEST on a running brain: they change it and read its state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from math import inf
from typing import Any

import numpy as np

from nrp_core.brain import IntArray, Network
from nrp_core.clock import nanoseconds
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.network.nest_models import LEAK_NS
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM
from nrp_pynest.built import BuiltBrain
from nrp_pynest.joining import Joined
from nrp_pynest.kernel import Block, Group, Kernel
from nrp_pynest.models import (
    CELLS,
    FOREVER_MS,
    MULTIMETERS,
    NEST_OF,
    PARROT,
    POISSON,
    POISSONS,
    SPIKE_RECORDERS,
    SPIKES,
    STANDARD,
    STATES,
    SynapseModel,
    states_of,
)
from nrp_pynest.network import Conversion

_SYNAPSES = {STATIC: "static_synapse", TSODYKS_MARKRAM: "tsodyks_synapse", STDP: "stdp_synapse"}
_TSODYKS = {"tau_facil": "tau_fac"}


class RunningKernel(Kernel):
    """A kernel whose nodes and synapses become those of a running brain.

    If the brain was not created by calls of NEST, its neurons are nodes in order, as with pyNN.nest.

    Args:
        random: the source of every random number.
        built: the objects of the brain file.
        is_lenient: as for every kernel.

    Attributes:
        joined: the cells of PyNN that nodes beside them have become.
    """

    def __init__(self, random: np.random.RandomState, built: BuiltBrain, *, is_lenient: bool = False) -> None:
        self._built = built
        self._now: Conversion | None = None
        self._numbering: tuple[dict[int, int], dict[int, list[int]]] | None = None
        self._owners: dict[int, int] | None = None
        self._labels: list[str] | None = None
        self._since_ms: dict[int, float] = {}
        super().__init__(random, is_lenient=is_lenient)
        self.joined = Joined()

    def begin(self, run: Run) -> None:
        """Connect to a run; its resets undo all changes."""
        first = deepcopy(([one.values for one in self.groups], [one.values for one in self.blocks]))

        def reset(_loop: object) -> None:
            self.forget()
            self._since_ms.clear()
            groups, blocks = deepcopy(first)
            if not groups:
                self.groups, self.blocks, self._labels = [], [], None
            for group, columns in zip(self.groups, groups, strict=True):
                group.values = columns
            for block, values in zip(self.blocks, blocks, strict=True):
                block.values = values

        run.loop.hooks.after_reset.append(reset)

    def ready(self) -> None:
        if self._built.is_running:
            self._known_labels()

    def forget(self) -> None:
        """Convert the nodes anew when they are next needed."""
        self._now = self._numbering = self._owners = None

    def _known_labels(self) -> list[str]:
        """Return the labels of the brain's projections, in the order of those that are converted."""
        network = self._built.network
        if self._labels is None:
            made_here = [one.label for one in network.projections]
            self._labels = made_here if self.groups else _describe(self._built, self)
        return self._labels

    def _converted(self) -> Conversion:
        if self._now is None:
            self._now = Conversion(self)
        return self._now

    def _numbers(self) -> tuple[dict[int, int], dict[int, list[int]]]:
        """Return the neurons of nodes, and the sources of Poisson generators, which never change."""
        if self._numbering is None:
            made = self._converted()
            self._numbering = made.ids, made.sources
        return self._numbering

    @contextmanager
    def changing(self) -> Iterator[None]:
        if not self._built.is_running:
            yield
            return
        self.ready()
        self.read_weights()
        before = self._converted().network
        yield
        self._now = None
        self._apply(before, self._converted().network)

    def _apply(self, before: Network, after: Network) -> None:
        """Apply the differences between two descriptions of the brain to it."""
        old, new = ([(one.receptor, one.size) for one in two.projections] for two in (before, after))
        if old != new:
            raise NetworkError("nest: the sign of a weight cannot change while the brain runs")
        for was, now in zip(before.populations.values(), after.populations.values(), strict=True):
            first = before.offsets[was.label]
            for name, values in now.parameters.items():
                places = np.flatnonzero(values != was.parameters[name])
                if places.size:
                    self._built.set_parameters(first + places, {name: values[places]})
            for place, train in enumerate(now.spike_times_ms):
                if not np.array_equal(train, was.spike_times_ms[place]):
                    self._built.set_parameters(np.array([first + place]), {"spike_times": [train]})
        for label, one, other in zip(
            self._known_labels(), before.projections, after.projections, strict=True
        ):
            if (one.weight != other.weight).any():
                self._built.brain.set_weights(label, other.weight)

    def now(self) -> dict[str, float]:
        now_ms = self._built.now_ms
        return {"time": now_ms, "biological_time": now_ms}

    def read_weights(self) -> None:
        if not self._built.is_running:
            return
        for label, (block, places, scale) in zip(self._known_labels(), self._converted().places, strict=True):
            weights = self._built.brain.read_weights(label) / scale
            if not np.array_equal(weights, block.values["weight"][places]):
                block.values["weight"] = np.array(block.values["weight"])  # which may share memory
                block.values["weight"][places] = weights
                self._now = None

    def set_nodes(self, nodes: Sequence[int], values: Any) -> None:
        if not self._built.is_running:
            super().set_nodes(nodes, values)
            return
        self._require_changeable(nodes, values)
        others: list[tuple[int, Any]] = []
        for node, given in zip(nodes, self.for_each(nodes, values), strict=True):
            if not given.get("n_events", 1):
                self._since_ms[int(node)] = self._built.now_ms
            if int(node) in self.joined.sources:
                self._set_sources(int(node), given)
            elif given.keys() == {"rate"} and self.group_of(node).base in POISSONS:
                self._set_rate(int(node), float(given["rate"]))
            elif int(node) not in self.joined.recorded:
                others.append((self._number(node), given))
        if others:
            super().set_nodes([node for node, _ in others], [given for _, given in others])

    def _require_changeable(self, nodes: Sequence[int], values: Any) -> None:
        """Check that no state of a cell is set while it runs.

        Raises:
            NetworkError: one is.
        """
        given = {name for one in ([values] if isinstance(values, Mapping) else values) for name in one}
        state = min(given & STATES.keys(), default=None)
        if state and not self.is_lenient and any(self.group_of(node).base in CELLS for node in nodes):
            raise NetworkError(
                f"nest: '{state}' of a cell cannot be set at {self._built.now_ms:g} ms, while the network "
                "runs; set it before the first Simulate"
            )

    def _set_rate(self, node: int, rate_hz: float) -> None:
        """Change the rate of a Poisson generator without a comparison of the whole network."""
        group = self.group_of(node)
        group.set("rate", [node - group.first], [rate_hz])
        self._now = None
        self._set_source_rates(self._numbers()[1].get(node, ()), rate_hz)

    def _set_source_rates(self, sources: Sequence[int], rate_hz: float) -> None:
        if sources:
            ids = np.array(sources, dtype=np.int64)
            self._built.set_parameters(ids, {"rate": np.full(len(ids), rate_hz)})

    def _number(self, node: int) -> int:
        """Return the node that a node beside cells of PyNN has become."""
        cell = self.joined.cells.get(int(node))
        return node if cell is None else cell + 1

    def _set_sources(self, node: int, given: Mapping[str, Any]) -> None:
        """Change a Poisson generator beside cells of PyNN."""
        if given.keys() - {"rate"}:
            name = min(given.keys() - {"rate"})
            raise NetworkError(f"nest: '{name}' of a Poisson generator cannot change while the brain runs")
        if "rate" in given:
            self._set_source_rates(self.joined.sources[node], float(given["rate"]))

    def node_values(self, node: int) -> dict[str, Any]:
        self.ready()
        if int(node) in self.joined.recorded:
            return {"global_id": int(node), "n_events": 0, "events": {}, **self._recorded_cells(node)}
        if int(node) in self.joined.sources:
            rate = self._built.parameter("rate")[self.joined.sources[int(node)][0]]
            return {"global_id": int(node), "model": POISSON, "rate": float(rate)}
        values = super().node_values(self._number(node))
        if not self._built.is_running:
            return values
        cells, group = self._numbers()[0], self.group_of(node)
        if group.base in CELLS and group.base != PARROT:
            brain = self._built.brain
            values |= {
                name: float(brain.read_state(own, [cells[node]])[0]) / factor
                for name, (own, factor) in states_of(group.base).items()
                if own in brain.capabilities.state_variables
            }
        elif group.base in SPIKE_RECORDERS:
            values |= self._within(node, self._recorded_cells(node))
        elif group.base in MULTIMETERS:
            values |= self._within(node, self._recorded_states(node))
        return values

    def _recorded_states(self, node: int) -> dict[str, Any]:
        """Return the samples of a multimeter so far, in NEST's order: by slice of time, neuron, and time."""
        interval_ms, states = self.samples_of(node)
        ids = np.array(sorted(self._numbers()[0][one] for one in self.measured_by(node)), dtype=np.int64)
        nodes = {cell: one for one, cell in self._numbers()[0].items()}
        columns: dict[str, Any] = {}
        for name, (variable, factor) in states.items():
            times_ms, values = self._built.samples(variable, ids, interval_ms)
            kept = (nanoseconds(times_ms) > 0) & (nanoseconds(times_ms) <= self._told_ns())
            columns["times"] = np.repeat(times_ms[kept], len(ids))
            columns["senders"] = np.tile([nodes[cell] for cell in ids.tolist()], int(kept.sum()))
            columns[name] = values[kept].ravel() / factor
        if columns:
            slices = (nanoseconds(columns["times"]) - 1) // self._slice_ns()
            order = np.lexsort((columns["times"], columns["senders"], slices))
            columns = {name: column[order] for name, column in columns.items()}
        return {"n_events": len(columns["times"]), "events": columns} if columns else {}

    def _told_ns(self) -> int:
        """Return the time to which NEST tells samples: it collects them at multiples of the least delay."""
        every_ns, now_ns = self._slice_ns(), int(nanoseconds(self._built.now_ms))
        return max(now_ns - 1, 0) // every_ns * every_ns

    def _slice_ns(self) -> int:
        """Return the least delay of all synapses."""
        delays = [float(block.values["delay"].min()) for block in self.blocks if len(block.pre)]
        return int(nanoseconds(min(delays, default=1.0)))

    def measured(self, made: Conversion) -> Iterator[tuple[str, IntArray, float]]:
        """Yield what the multimeters record: state variables, each with cells and the interval, ms."""
        for group in (one for one in self.groups if one.base in MULTIMETERS):
            for node in range(group.first, group.first + group.size):
                ids = np.array(sorted(made.ids[one] for one in self.measured_by(node)), dtype=np.int64)
                interval_ms, states = self.samples_of(node)
                if len(ids):
                    yield from ((variable, ids, interval_ms) for variable, _ in states.values())

    def measured_by(self, node: int) -> list[int]:
        """Return the cells that a multimeter measures."""
        targets = [block.post[block.pre == node] for block in self.blocks]
        every = np.unique(np.concatenate([np.empty(0, np.int64), *targets])).tolist()
        return [one for one in every if self.group_of(one).base in CELLS]

    def samples_of(self, node: int) -> tuple[float, dict[str, tuple[str, float]]]:
        """Return the interval of a multimeter, ms, and what it records: names of NEST and of the network.

        Raises:
            NetworkError: its cells have no such state variable.
        """
        own = super().node_values(node)
        cells = {self.group_of(one).base for one in self.measured_by(node)}
        states = [states_of(base) for base in cells]
        known = {
            name: one
            for name, one in (states[0] if states else STATES).items()
            if all(others.get(name) == one for others in states)
        }
        asked = own["record_from"] if not isinstance(own["record_from"], str) else [own["record_from"]]
        for name in asked if not self.is_lenient else ():
            if name not in known:
                raise NetworkError(
                    f"nest: '{own['model']}' cannot record '{name}' of {min(cells, default='no cell')} here"
                    f"{did_you_mean(name, known)}"
                )
        return float(own["interval"]), {name: known[name] for name in asked if name in known}

    def _within(self, node: int, recorded: dict[str, Any]) -> dict[str, Any]:
        """Return what a recorder recorded between its start and its stop, and since it was emptied."""
        if not recorded:
            return recorded
        own, events = super().node_values(node), recorded["events"]
        first, last, since = nanoseconds([
            min(own.get("origin", 0.0) + own.get(name, default), FOREVER_MS)
            for name, default in (("start", 0.0), ("stop", FOREVER_MS))
        ] + [max(self._since_ms.get(int(node), 0.0), 0.0)]).tolist()  # fmt: skip
        times_ns = nanoseconds(events["times"])
        kept = (times_ns > max(first, since)) & (times_ns <= last)
        events = {name: column[kept] for name, column in events.items()}
        return {"n_events": len(events["times"]), "events": events}

    def recorded_ids(self, made: Conversion, node: int) -> IntArray:
        """Return the neurons whose spikes a recorder records, ascending."""
        ids = [made.ids[one] for one in self.recorded_by(node).tolist() if one in made.ids]
        return np.array(sorted({*ids, *made.heard.get(int(node), ())}), dtype=np.int64)

    def _recorded_cells(self, node: int) -> dict[str, Any]:
        """Return the spikes of a recorder so far."""
        made = self._converted()
        heard = self.joined.recorded.get(int(node))
        heard = self.recorded_ids(made, node) if heard is None else heard
        if not heard.size:
            return {}
        if self._owners is None:
            self._owners = {cell: node for node, cells in made.sources.items() for cell in cells}
            self._owners |= {cell: node for node, cell in made.ids.items()}  # parrots repeat generators
        spikes = self._built.spikes(heard).within(self._since_ms.get(int(node), -inf), inf)
        senders = np.array([self._owners[cell] for cell in spikes.neurons.tolist()], dtype=np.int64)
        return {"n_events": len(spikes), "events": {"senders": senders, "times": spikes.times_ms}}


def _describe(built: BuiltBrain, kernel: Kernel) -> list[str]:
    """Replace nodes and synapses by those of a brain; return the labels of the corresponding projections."""
    groups: dict[str, Group] = {}
    network = built.network
    for label, population in network.populations.items():
        base = NEST_OF.get(population.cell_type, SPIKES)
        first = network.offsets[label] + 1
        columns = _columns(base, built, network.ids_of(label))
        groups[label] = Group(base, base, first, population.size, dict(kernel.defaults(base)), columns)
    kernel.groups, labels = list(groups.values()), list[str]()
    for one in network.projections:
        target = groups[one.post]
        if not one.size or target.base not in STANDARD:
            continue
        sign = -1.0 if one.receptor == "inhibitory" else 1.0
        weight = sign * np.abs(built.brain.read_weights(one.label)) / STANDARD[target.base].weight_scale
        more = {_TSODYKS.get(name, name): column.copy() for name, column in one.synapse_parameters.items()}
        values = {"weight": weight, "delay": one.delay_ms.copy(), **more}
        ends = groups[one.pre].first + one.pre_index, target.first + one.post_index
        pre, post = (end.astype(np.int64) for end in ends)
        unchanging = SynapseModel(STATIC, {})
        kernel.blocks.append(Block(_SYNAPSES[one.synapse_type], unchanging, pre, post, values, kernel))
        labels.append(one.label)
    return labels


def _columns(base: str, built: BuiltBrain, ids: IntArray) -> dict[str, list[Any]]:
    """Return the parameters of neurons in the names and units of NEST."""
    if base not in STANDARD:
        return {}
    columns = {
        theirs.name: (built.parameter(ours)[ids] / theirs.scale).tolist()
        for ours, theirs in STANDARD[base].parameters.items()
    }
    if base in LEAK_NS:
        columns["g_L"] = (built.parameter("cm")[ids] * 1e3 / built.parameter("tau_m")[ids]).tolist()
        columns.pop("tau_m", None)
    return columns
