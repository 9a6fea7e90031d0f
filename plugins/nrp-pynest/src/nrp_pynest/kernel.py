"""The nodes with parameters, and the synapses, created by calls of NEST; parameters may be random."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from nrp_core.brain import FloatArray, IntArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.findings import Code, Findings
from nrp_core.seeds import Seeds
from nrp_pynest.models import (
    CELLS,
    CURRENTS,
    GENERATORS,
    IDLE,
    LISTS,
    PARROT,
    RECORDER_DEFAULTS,
    RECORDERS,
    SPIKE_RECORDERS,
    STATES,
    SYNAPSES,
    WITHOUT_EFFECT,
    SynapseModel,
    defaults_of,
    initial_mv,
    recordables,
)
from nrp_pynest.parameters import Places, drawn, is_random
from nrp_pynest.spatial import Layer

_WITHOUT_MEMBRANE = {
    **dict.fromkeys(CURRENTS, (PARROT, *GENERATORS, *SPIKE_RECORDERS)), "multimeter": (PARROT,),
    "voltmeter": (PARROT,),
}  # fmt: skip
"""The nodes to which some nodes cannot be connected."""
_AFTER_CELLS = 10**9
"""The number of the first node in a script that has created cells otherwise."""


class Node(int):
    """A node, by number; also a collection of one node, as in NEST 3."""

    _kernel: Kernel

    @classmethod
    def of(cls, kernel: Kernel, number: int) -> Node:
        """Return the node with a number."""
        made = cls(number)
        made._kernel = kernel
        return made

    def _alone(self) -> Nodes:
        return Nodes.of(self._kernel, [self])

    def __len__(self) -> int:
        return 1

    def __iter__(self) -> Iterator[Node]:
        return iter((self,))

    def __getitem__(self, index: Any) -> Any:
        return self._alone()[index]

    def __add__(self, other: Any) -> Any:
        return self._alone() + other if isinstance(other, (Node, Nodes)) else int(self) + other

    def __getattr__(self, name: str) -> Any:
        return getattr(self._alone(), name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            super().__setattr__(name, value)
        else:
            self.set({name: value})


class Nodes(tuple[Node, ...]):  # noqa: SLOT001 - they know their kernel
    """An ordered collection of nodes, with the methods of NEST 3."""

    _kernel: Kernel

    @classmethod
    def of(cls, kernel: Kernel, numbers: Iterable[int]) -> Nodes:
        """Return the nodes with these numbers."""
        made = cls(Node.of(kernel, number) for number in numbers)
        made._kernel = kernel
        return made

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, (list, np.ndarray)):
            return Nodes.of(self._kernel, (int(self[i]) for i in np.arange(len(self))[np.asarray(index)]))
        chosen = super().__getitem__(index)
        return Nodes.of(self._kernel, chosen) if isinstance(index, slice) else chosen

    def __add__(self, other: Any) -> Nodes:
        return Nodes.of(self._kernel, (*self, *other))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or not self or name not in self._kernel.node_values(self[0]):
            raise AttributeError(f"nodes do not have the attribute '{name}'")
        return self.get(name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            super().__setattr__(name, value)
        else:
            self.set({name: value})

    @property
    def spatial(self) -> dict[str, Any] | None:
        """The positions; None for nodes without."""
        layer = self._kernel.group_of(self[0]).layer if self else None
        return None if layer is None else layer.described(len(self))

    def tolist(self) -> list[int]:
        """Return the numbers."""
        return list(map(int, self))

    def set(self, params: Any = None, **fields: Any) -> None:
        """Set parameters."""
        if isinstance(params, (list, tuple)):
            self._kernel.set_nodes(self, params)
        else:
            self._kernel.set_nodes(self, {**(params or {}), **fields})

    def get(self, *names: Any, output: str = "") -> Any:
        """Return parameters: the value for one node, a tuple for several; a dictionary for several names."""
        found = [self._kernel.node_values(node) for node in self]
        if names and isinstance(names[0], str):
            values = tuple(one.get(names[0]) for one in found)
            if len(names) > 1:  # a value of a dictionary, such as ("events", "times")
                asked: Any = names[1]
                parts = [dict(one or {}) for one in values]
                values = tuple(
                    one[asked] if isinstance(asked, str) else {key: one[key] for key in asked}
                    for one in parts
                )
            return values[0] if len(values) == 1 else values
        keys = list(names[0]) if names else list(found[0])
        table = {key: tuple(one.get(key) for one in found) for key in keys}
        if output == "pandas":
            import pandas as pd

            return pd.DataFrame(table, index=self.tolist())
        return {key: values[0] for key, values in table.items()} if len(found) == 1 else table


@dataclass
class Group:
    """The nodes of one call of ``Create``.

    Args:
        model: the name in the call.
        base: the underlying model of NEST.
        first: number of the first node.
        size: number of nodes.
        values: parameters that were set, one value for each node.
        defaults: the default values of the other parameters.
        layer: the positions of the nodes.
    """

    model: str
    base: str
    first: int
    size: int
    defaults: dict[str, Any]
    values: dict[str, list[Any]] = field(default_factory=dict)
    layer: Layer | None = None

    def set(self, name: str, places: Sequence[int], values: Sequence[Any]) -> None:
        """Set a parameter of some nodes."""
        kept = self.values.setdefault(name, [self.defaults.get(name, np.nan)] * self.size)
        for place, value in zip(places, values, strict=True):
            kept[place] = value

    def column(self, name: str, default: float) -> FloatArray:
        """Return a parameter of all nodes."""
        given = self.values.get(name, [self.defaults.get(name, default)] * self.size)
        values = np.array(given, dtype=float)
        return np.where(np.isnan(values), default, values)


@dataclass
class Block:
    """The synapses of one call of ``Connect``; every array has one value per synapse."""

    model: str
    base: SynapseModel
    pre: IntArray
    post: IntArray
    values: dict[str, FloatArray]
    kernel: Kernel


class CellsBeside(Protocol):
    """Cells that something else than calls of NEST creates, by numbers from 0."""

    def __len__(self) -> int: ...

    def get(self, cell: int) -> dict[str, Any]:
        """Return the parameters of a cell."""

    def set(self, cell: int, values: Mapping[str, Any]) -> None:
        """Change parameters of a cell."""


def random_of(seed: int) -> np.random.RandomState:
    """Return the random numbers of calls of NEST in a brain file."""
    return np.random.RandomState(Seeds(seed).child("network").stream("nest").bit_generator)


class Kernel:
    """Everything that one script creates.

    Args:
        random: the source of every random number.
        is_lenient: whether nodes and synapses of unknown models are noted and left out, instead of refused.

    Attributes:
        notes: calls that are not supported.
        beside: cells that are not nodes; nodes that are created later have larger numbers than any cell.
        is_beside: whether there will be such cells, so that earlier nodes have larger numbers, too.
    """

    beside: CellsBeside | None = None
    is_beside: bool = False

    def __init__(self, random: np.random.RandomState, *, is_lenient: bool = False) -> None:
        self.random, self.is_lenient = random, is_lenient
        self.notes = Findings()
        self.status: dict[str, Any] = {}
        self.clear()

    def clear(self) -> None:
        """Remove everything."""
        self.status = {
            "resolution": 0.1, "time": 0.0, "local_num_threads": 1, "total_num_virtual_procs": 1,
            "min_delay": 0.1, "max_delay": 20.0, "rng_seeds": (1,), "grng_seed": 1, "rng_seed": 143202461,
            "num_processes": 1, "print_time": False, "overwrite_files": False, "data_path": "",
            "data_prefix": "", **dict.fromkeys(_TIMES, 0.0),
        }  # fmt: skip
        self.groups: list[Group] = []
        self.blocks: list[Block] = []
        self._models: dict[str, tuple[str, dict[str, Any]]] = {}
        self.copies: dict[str, tuple[str, dict[str, Any]]] = {}
        self._synapses: dict[str, SynapseModel] = dict(SYNAPSES)

    # -- with a running brain, see :mod:`nrp_pynest.running`

    def ready(self) -> None:
        """Prepare for a call."""

    def changing(self) -> AbstractContextManager[None]:
        """Return the context of changes of nodes and synapses."""
        return nullcontext()

    def now(self) -> dict[str, float]:
        """Return the properties of the kernel about time."""
        return {}

    def simulate(self, t_ms: float) -> None:
        """Note that nothing runs, because the experiment runs the network."""
        message = "the brain file calls Simulate: ignored, because the experiment runs the network"
        self.notes.add(Code.NRP217, message, subject="Simulate")

    def set_status(self, values: Mapping[str, Any]) -> None:
        """Set properties of the simulator."""
        self.status.update(values)
        if "rng_seed" in values:
            self.random = np.random.RandomState(int(values["rng_seed"]) % 2**32)

    def is_device(self, block: Block) -> bool:
        """Return whether synapses lead to or from a device that only records."""
        first = (block.pre[:1].tolist() + block.post[:1].tolist()) if not self.is_lenient else []
        return any(self.group_of(node).base in RECORDERS for node in first)

    def read_weights(self) -> None:
        """Update the weights of plastic synapses."""

    def recorded_by(self, node: int) -> IntArray:
        """Return the nodes whose spikes a recorder records."""
        sources = [block.pre[block.post == node] for block in self.blocks]
        return np.unique(np.concatenate([np.empty(0, np.int64), *sources]))

    # -- models

    def model(self, name: str) -> tuple[str, dict[str, Any]]:
        """Return the model of NEST with a name, and its defaults.

        Raises:
            NetworkError: it is not supported, and this kernel is not lenient.
        """
        if name not in self._models:
            if name not in (*CELLS, *GENERATORS, *RECORDER_DEFAULTS):
                effect = IDLE.get(name) or f"its nodes do nothing{did_you_mean(name, CELLS)}"
                self._leave_out(f"model '{name}' is not supported", effect, name)
            self._models[name] = name, defaults_of(name)
        return self._models[name]

    def _leave_out(self, what: str, effect: str, name: str) -> None:
        if not self.is_lenient:
            raise NetworkError(f"nest: the {what} here")
        self.notes.add(Code.NRP385, f"NEST's {what}: {effect}", subject=name)

    def synapse_model(self, name: str) -> SynapseModel:
        """Return a model of synapses.

        Raises:
            NetworkError: it is not supported, and this kernel is not lenient.
        """
        if name not in self._synapses:
            effect = "its synapses are static_synapse, so their weights do not change"
            self._leave_out(f"synapse model '{name}' is not supported", effect, name)
            self._synapses[name] = SYNAPSES["static_synapse"]
        return self._synapses[name]

    def defaults(self, name: str) -> dict[str, Any]:
        """Return the defaults of a model, and what else NEST tells of it."""
        if name in self._synapses:
            count = sum(len(block.pre) for block in self.blocks if block.model == name)
            return {
                **self._synapses[name].defaults, "num_connections": count, "synapse_model": name,
                "receptor_type": 0,
            }  # fmt: skip
        base, values = self.model(name)
        kind = "recorder" if base in RECORDERS else "stimulator" if base in GENERATORS else "neuron"
        told: dict[str, Any] = {"element_type": kind, "model": name, **values}
        if base in CELLS:
            told = {"V_m": initial_mv(base), "recordables": recordables(base), **told}
        return told

    def set_defaults(self, name: str, values: Mapping[str, Any]) -> None:
        """Change the defaults of a model."""
        self.copy(name, name, values)

    def copy(self, name: str, new: str, values: Mapping[str, Any]) -> None:
        """Create a model from another one."""
        if name in self._synapses or "synapse" in name.split("_"):
            known = self.synapse_model(name)
            self._require_names(name, known.defaults.keys() | _OF_SYNAPSES, values)
            self._synapses[new] = known.changed(values)
        else:
            base, defaults = self.model(name)
            self._require_names(name, self._names(base), values)
            self._models[new] = self.copies[new] = base, {**defaults, **values}

    def _names(self, base: str) -> Iterable[str]:
        """Return the parameters and state variables of a model that may be set."""
        own = defaults_of(base).keys()
        return (
            {*own, *STATES, *WITHOUT_EFFECT, "tau_syn", "n_events"} if base in CELLS else {*own, *_OF_DEVICES}
        )

    def _require_names(self, model: str, known: Iterable[str], values: Mapping[str, Any]) -> None:
        for name in values.keys() - set(known) if not self.is_lenient else ():
            raise NetworkError(f"nest: '{model}' has no parameter '{name}' here{did_you_mean(name, known)}")

    # -- nodes

    def create(self, name: str, size: int, values: Any, layer: Layer | None = None) -> Nodes:
        """Create nodes, at positions if there is a layer."""
        base, defaults = self.model(name)
        after_cells = _AFTER_CELLS if self.beside or self.is_beside else 1
        first = self.groups[-1].first + self.groups[-1].size if self.groups else after_cells
        self.before_nodes(base)
        self.groups.append(Group(name, base, first, size, dict(defaults), layer=layer))
        nodes = Nodes.of(self, range(first, first + size))
        if values:
            self.set_nodes(nodes, values)
        return nodes

    def before_nodes(self, base: str) -> None:
        """Called before nodes of a model are created."""

    def group_of(self, node: int) -> Group:
        """Return the group of a node.

        Raises:
            NetworkError: the node does not exist.
        """
        place = bisect_right(self.groups, int(node), key=lambda group: group.first) - 1
        if place < 0 or node >= self.groups[place].first + self.groups[place].size:
            raise NetworkError(f"nest: node {node} does not exist")
        return self.groups[place]

    def positions_of(self, nodes: Sequence[int]) -> FloatArray | None:
        """Return the positions of nodes, shape ``(n, dimensions)``; None if one has none."""
        found = []
        for group in self.groups:
            own = [int(node) - group.first for node in nodes if 0 <= node - group.first < group.size]
            if own and group.layer is None:
                return None
            if own and group.layer is not None:
                found.append(group.layer.positions[own])
        return np.concatenate(found) if found else None

    def set_nodes(self, nodes: Sequence[int], values: Any) -> None:
        """Set parameters of nodes: a dictionary for all, or one for each; a list has a value for each."""
        each = self.for_each(nodes, values)
        with self.changing():
            for node, given in zip(nodes, each, strict=True):
                if self.beside and node < len(self.beside):
                    self.beside.set(int(node), given)
                    continue
                group = self.group_of(node)
                self._require_names(group.model, self._names(group.base), given)
                for name, value in given.items():
                    group.set(name, [node - group.first], [value])

    def for_each(self, nodes: Sequence[int], values: Any) -> Sequence[Mapping[str, Any]]:
        """Return the parameters of each node, given as for :meth:`set_nodes`."""
        if not isinstance(values, Mapping):
            return values * len(nodes) if len(values) == 1 else values  # type: ignore[no-any-return]
        places = Places(len(nodes), self.random, self._where(nodes, values))
        spread = {name: _spread(value, places, name) for name, value in values.items()}
        return [{name: column[i] for name, column in spread.items()} for i in range(len(nodes))]

    def _where(self, nodes: Sequence[int], values: Mapping[str, Any]) -> FloatArray | None:
        return self.positions_of(nodes) if any(map(is_random, values.values())) else None

    def node_values(self, node: int) -> dict[str, Any]:
        """Return the parameters of a node."""
        if self.beside and node < len(self.beside):
            return self.beside.get(int(node))
        group = self.group_of(node)
        own = {name: values[node - group.first] for name, values in group.values.items()}
        known = {**self.defaults(group.model), "global_id": int(node), "model": group.model}
        if group.base in RECORDERS:
            known |= {"n_events": 0, "events": {}}
        return {**known, **group.defaults, **own}

    # -- synapses

    def connect(
        self, pre: IntArray, post: IntArray, name: str, given: Mapping[str, Any], places: Places,
        weave: Callable[[Any], Any],
    ) -> Block:  # fmt: skip
        """Create synapses.

        Args:
            pre: a node for each synapse.
            post: a node for each synapse.
            name: name of their model.
            given: weight, delay and parameters: numbers, arrays, or distributions.
            places: where the synapses are.
            weave: returns the values, one per synapse, of an array over pairs of nodes.
        """
        self._require_integrating(pre, post)
        self.before_synapses(pre, post)
        base = self.synapse_model(name)
        self._require_names(name, base.defaults.keys() | _OF_SYNAPSES, given)
        values = {
            key: drawn(value, places) if is_random(value) else np.broadcast_to(weave(value), (len(pre),))
            for key, value in {**base.defaults, **given}.items()
            if not isinstance(value, str) and value is not None
        }
        self.blocks.append(Block(name, base, pre, post, values, self))
        return self.blocks[-1]

    def before_synapses(self, pre: IntArray, post: IntArray) -> None:
        """Called before synapses between nodes are created."""

    def _require_integrating(self, pre: IntArray, post: IntArray) -> None:
        """Check that currents and voltmeters are connected to nodes with a membrane.

        Raises:
            NetworkError: they are not; NEST refuses it too (``IllegalConnection``).
        """
        for sender in self.groups:
            others = _WITHOUT_MEMBRANE.get(sender.base, ())
            sent = post[(pre >= sender.first) & (pre < sender.first + sender.size)] if others else post[:0]
            for target in self.groups if sent.size else ():
                inside = (sent >= target.first) & (sent < target.first + target.size)
                if target.base in others and inside.any():
                    raise NetworkError(
                        f"nest.Connect: '{sender.model}' cannot be connected to '{target.model}', whose "
                        "nodes have no membrane (NEST refuses it too); valid: models such as iaf_cond_exp"
                    )


def _spread(value: Any, places: Places, name: str) -> Sequence[Any]:
    if is_random(value):
        return list(drawn(value, places).tolist())
    is_list = isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0
    if is_list and name not in LISTS and len(value) == places.n:
        return list(value)
    return [value] * places.n


_OF_SYNAPSES = frozenset(
    {"weight", "delay", "receptor_type", "x", "y", "u", "Kplus", "tau_psc", "synapse_label"}
)
_TIMES = (
    "time_construction_create", "time_construction_connect", "time_simulate", "time_communicate_prepare",
    "time_collocate_spike_data", "time_deliver_spike_data", "time_gather_spike_data", "time_update",
)  # fmt: skip
"""Times of the computer that NEST measures; here they are 0."""
_OF_DEVICES = frozenset({"n_events", "time_in_steps", "individual_spike_trains"})
