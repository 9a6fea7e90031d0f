"""The nodes with parameters, and the synapses, created by calls of NEST; parameters may be random."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
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
    CURRENT,
    GENERATORS,
    IDLE,
    PARROT,
    SPIKE_RECORDERS,
    SYNAPSES,
    SynapseModel,
    defaults_of,
    initial_mv,
)


def is_random(value: Any) -> bool:
    """Return whether a value describes random numbers."""
    return isinstance(value, Random) or (isinstance(value, Mapping) and "distribution" in value)


@dataclass(frozen=True)
class Random:
    """Numbers from a distribution, such as ``nest.random.uniform``; arithmetic is possible."""

    draw: Callable[[np.random.RandomState, int], FloatArray]

    def __add__(self, other: float) -> Random:
        return Random(lambda random, n: self.draw(random, n) + other)

    def __mul__(self, factor: float) -> Random:
        return Random(lambda random, n: self.draw(random, n) * factor)

    __radd__, __rmul__ = __add__, __mul__

    def __sub__(self, other: float) -> Random:
        return self + -other

    def __neg__(self) -> Random:
        return self * -1.0


def uniform(low: float = 0.0, high: float = 1.0) -> Random:
    """Return a uniform distribution."""
    return Random(lambda random, n: random.uniform(low, high, n))


def normal(mean: float = 0.0, std: float = 1.0) -> Random:
    """Return a normal distribution."""
    return Random(lambda random, n: random.normal(mean, std, n))


def lognormal(mean: float = 0.0, std: float = 1.0) -> Random:
    """Return a lognormal distribution."""
    return Random(lambda random, n: random.lognormal(mean, std, n))


def exponential(beta: float = 1.0) -> Random:
    """Return an exponential distribution."""
    return Random(lambda random, n: random.exponential(beta, n))


def drawn(value: Any, n: int, random: np.random.RandomState) -> FloatArray:
    """Return numbers from a distribution, also in the notation of NEST 2.

    Raises:
        NetworkError: it is unknown.
    """
    if isinstance(value, Mapping):
        kind = str(value["distribution"])
        numbers = {key: float(one) for key, one in value.items() if key != "distribution"}
        known: dict[str, Callable[[], Random]] = {
            "uniform": lambda: uniform(numbers.get("low", 0.0), numbers.get("high", 1.0)),
            "normal": lambda: normal(numbers.get("mu", 0.0), numbers.get("sigma", 1.0)),
            "lognormal": lambda: lognormal(numbers.get("mu", 0.0), numbers.get("sigma", 1.0)),
            "exponential": lambda: exponential(1.0 / numbers.get("lambda", 1.0)),
        }
        root = kind.removesuffix("_clipped").removesuffix("_clipped_to_boundary")
        if root not in known:
            raise NetworkError(f"nest: the distribution '{kind}' is not supported{did_you_mean(root, known)}")
        return np.clip(
            known[root]().draw(random, n), numbers.get("low", -np.inf), numbers.get("high", np.inf)
        )
    numbers_drawn: FloatArray = value.draw(random, n)
    return numbers_drawn


_WITHOUT_MEMBRANE = {
    CURRENT: (PARROT, *GENERATORS, *SPIKE_RECORDERS), "multimeter": (PARROT,), "voltmeter": (PARROT,)
}  # fmt: skip
"""The nodes to which some nodes cannot be connected."""
_AFTER_CELLS = 10**9
"""The number of the first node in a script that has created cells otherwise."""


class Node(int):
    """A node, by number."""


class Nodes(tuple[Node, ...]):  # noqa: SLOT001 - they know their kernel
    """An ordered collection of nodes, with the methods of NEST 3."""

    _kernel: Kernel

    @classmethod
    def of(cls, kernel: Kernel, numbers: Iterable[int]) -> Nodes:
        """Return the nodes with these numbers."""
        made = cls(Node(number) for number in numbers)
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

    def tolist(self) -> list[int]:
        """Return the numbers."""
        return list(map(int, self))

    def set(self, params: Any = None, **fields: Any) -> None:
        """Set parameters."""
        self._kernel.set_nodes(self, {**(params or {}), **fields})

    def get(self, *names: Any) -> Any:
        """Return parameters: the value for one node, a tuple for several."""
        found = [self._kernel.node_values(node) for node in self]
        if names and isinstance(names[0], str):
            values = tuple(one.get(names[0]) for one in found)
            return values[0] if len(values) == 1 else values
        return found[0] if len(found) == 1 else tuple(found)


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
    """

    model: str
    base: str
    first: int
    size: int
    defaults: dict[str, Any]
    values: dict[str, list[Any]] = field(default_factory=dict)

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


class Kernel:
    """Everything that one brain file creates.

    Args:
        seed: the seed of every random number.

    Attributes:
        notes: calls that are not supported.
        beside: cells that are not nodes; nodes that are created later have larger numbers than any cell.
        is_beside: whether there will be such cells, so that earlier nodes have larger numbers, too.
    """

    beside: CellsBeside | None = None
    is_beside: bool = False

    def __init__(self, seed: int) -> None:
        self.random = np.random.RandomState(Seeds(seed).child("network").stream("nest").bit_generator)
        self.notes = Findings()
        self.status: dict[str, Any] = {}
        self.clear()

    def clear(self) -> None:
        """Remove everything."""
        self.status = {
            "resolution": 0.1, "time": 0.0, "local_num_threads": 1, "total_num_virtual_procs": 1,
            "min_delay": 0.1, "max_delay": 20.0, "rng_seeds": (1,), "grng_seed": 1,
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

    def read_weights(self) -> None:
        """Update the weights of plastic synapses."""

    def recorded_by(self, node: int) -> IntArray:
        """Return the nodes whose spikes a recorder records."""
        sources = [block.pre[block.post == node] for block in self.blocks]
        return np.unique(np.concatenate([np.empty(0, np.int64), *sources]))

    # -- models

    def model(self, name: str) -> tuple[str, dict[str, Any]]:
        """Return the model of NEST with a name, and its defaults."""
        if name not in self._models:
            if name not in (*CELLS, *GENERATORS, *SPIKE_RECORDERS):
                effect = IDLE.get(name) or f"its nodes do nothing{did_you_mean(name, CELLS)}"
                self.notes.add(Code.NRP385, f"NEST's model '{name}' is not supported: {effect}", subject=name)
            self._models[name] = name, defaults_of(name)
        return self._models[name]

    def synapse_model(self, name: str) -> SynapseModel:
        """Return a model of synapses."""
        if name not in self._synapses:
            message = (
                f"NEST's synapse model '{name}' is not supported: its synapses are static_synapse, so their "
                "weights do not change"
            )
            self.notes.add(Code.NRP385, message, subject=name)
            self._synapses[name] = SYNAPSES["static_synapse"]
        return self._synapses[name]

    def defaults(self, name: str) -> dict[str, Any]:
        """Return the defaults of a model."""
        return dict(self._synapses[name].defaults if name in self._synapses else self.model(name)[1])

    def set_defaults(self, name: str, values: Mapping[str, Any]) -> None:
        """Change the defaults of a model."""
        self.copy(name, name, values)

    def copy(self, name: str, new: str, values: Mapping[str, Any]) -> None:
        """Create a model from another one."""
        if name in self._synapses or "synapse" in name.split("_"):
            self._synapses[new] = self.synapse_model(name).changed(values)
        else:
            base, defaults = self.model(name)
            self._models[new] = self.copies[new] = base, {**defaults, **values}

    # -- nodes

    def create(self, name: str, size: int, values: Any) -> Nodes:
        """Create nodes."""
        base, defaults = self.model(name)
        after_cells = _AFTER_CELLS if self.beside or self.is_beside else 1
        first = self.groups[-1].first + self.groups[-1].size if self.groups else after_cells
        self.groups.append(Group(name, base, first, size, dict(defaults)))
        nodes = Nodes.of(self, range(first, first + size))
        if values:
            self.set_nodes(nodes, values)
        return nodes

    def group_of(self, node: int) -> Group:
        """Return the group of a node.

        Raises:
            NetworkError: the node does not exist.
        """
        place = bisect_right(self.groups, int(node), key=lambda group: group.first) - 1
        if place < 0 or node >= self.groups[place].first + self.groups[place].size:
            raise NetworkError(f"nest: node {node} does not exist")
        return self.groups[place]

    def set_nodes(self, nodes: Sequence[int], values: Any) -> None:
        """Set parameters of nodes: a dictionary for all, or one for each; a list has a value for each."""
        each = self.for_each(nodes, values)
        with self.changing():
            for node, given in zip(nodes, each, strict=True):
                if self.beside and node < len(self.beside):
                    self.beside.set(int(node), given)
                    continue
                group = self.group_of(node)
                for name, value in given.items():
                    group.set(name, [node - group.first], [value])

    def for_each(self, nodes: Sequence[int], values: Any) -> Sequence[Mapping[str, Any]]:
        """Return the parameters of each node, given as for :meth:`set_nodes`."""
        if not isinstance(values, Mapping):
            return values  # type: ignore[no-any-return] # a dictionary for each
        spread = {name: _spread(value, len(nodes), name, self.random) for name, value in values.items()}
        return [{name: column[i] for name, column in spread.items()} for i in range(len(nodes))]

    def node_values(self, node: int) -> dict[str, Any]:
        """Return the parameters of a node."""
        if self.beside and node < len(self.beside):
            return self.beside.get(int(node))
        group = self.group_of(node)
        own = {name: values[node - group.first] for name, values in group.values.items()}
        known: dict[str, Any] = {"global_id": int(node), "model": group.model, "element_type": "neuron"}
        if group.base in CELLS:
            known["V_m"] = initial_mv(group.base)
        return {**known, "n_events": 0, "events": {}, **group.defaults, **own}

    # -- synapses

    def connect(
        self, pre: IntArray, post: IntArray, name: str, given: Mapping[str, Any], weave: Callable[[Any], Any]
    ) -> None:
        """Create synapses.

        Args:
            pre: a node for each synapse.
            post: a node for each synapse.
            name: name of their model.
            given: weight, delay and parameters: numbers, arrays, or distributions.
            weave: returns the values, one per synapse, of an array over pairs of nodes.
        """
        self._require_integrating(pre, post)
        base = self.synapse_model(name)
        values = {
            key: drawn(value, len(pre), self.random)
            if is_random(value)
            else np.broadcast_to(np.asarray(weave(value), float), (len(pre),)).copy()
            for key, value in {**base.defaults, **given}.items()
            if not isinstance(value, str) and value is not None
        }  # fmt: skip
        self.blocks.append(Block(name, base, pre, post, values, self))

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


def _spread(value: Any, n: int, name: str, random: np.random.RandomState) -> Sequence[Any]:
    if is_random(value):
        return list(drawn(value, n, random).tolist())
    is_list = isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0
    if is_list and name not in ("spike_times", "tau_syn") and len(value) == n:
        return list(value)
    return [value] * n
