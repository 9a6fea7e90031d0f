"""Computational graphs: nodes receive datapacks from engines and other nodes, and send some to engines.

The graph runs before each step of an engine, driven by its outputs: only nodes run from which a path leads to
an engine that is due. Of these, a node runs if one of its inputs is new, or always if it says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from inspect import signature
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NoReturn

from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.scripts import Scope
from nrp_ebrains.datapacks import DataPack, Identity
from nrp_ebrains.modules import registered_by

CLOCK, ITERATION = "clock", "iteration"
"""The inputs that are always new: simulated time in ms, and the number of the iteration."""
ALWAYS, ON_NEW_MESSAGE = "always", "on_new_message"
_POLICIES = SimpleNamespace(
    functional_node=SimpleNamespace(
        exec_policy=SimpleNamespace(always=ALWAYS, on_new_message=ON_NEW_MESSAGE)
    ),
    input_node=SimpleNamespace(
        cache_policy=SimpleNamespace(keep_cache="keep_cache", clear_cache="clear_cache"),
        msg_publish=SimpleNamespace(last="last", all="all"),
    ),
    output_node=SimpleNamespace(publish_from_cache=True),
)
_ELSEWHERE = (
    "RosSubscriber", "RosPublisher", "MQTTSubscriber", "MQTTPublisher", "FromSpinnaker", "ToSpinnaker",
)  # fmt: skip
"""Decorators of nodes for which there is no counterpart."""


@dataclass
class Node:
    """A functional node.

    Args:
        name: its name.
        outputs: the names of its return values, in order.
        call: its function.
        always: whether it runs without new inputs.
        engines: the datapack of an engine for each keyword.
        nodes: another node and its output for each keyword.
        counters: ``clock`` or ``iteration`` for each keyword.
        constants: the value of each keyword that a dummy gives.
        targets: the engine to which an output is sent.
        path: its file.
    """

    name: str
    outputs: tuple[str, ...]
    call: Callable[..., Any]
    always: bool
    engines: dict[str, Identity] = field(default_factory=dict)
    nodes: dict[str, tuple[str, str]] = field(default_factory=dict)
    counters: dict[str, str] = field(default_factory=dict)
    constants: dict[str, Any] = field(default_factory=dict)
    targets: dict[str, str] = field(default_factory=dict)
    path: Path | None = None

    def requested(self) -> Iterator[Identity]:
        """Yield the datapacks that engines must provide."""
        yield from self.engines.values()

    def engines_named(self) -> Iterator[str]:
        """Yield the engines that it names."""
        yield from self.targets.values()
        yield from (one.engine for one in self.requested())


class NodeDecorators:
    """The decorators of graph files, which register nodes here.

    Attributes:
        registered: the nodes so far.
    """

    def __init__(self) -> None:
        self.registered: list[Node] = []

    def names(self) -> Mapping[str, Any]:
        """Return the names that ``from nrp_core.event_loop import *`` gives a file."""
        return {
            "FunctionalNode": self._functional_node,
            "FromEngine": _from_engine,
            "FromFunctionalNode": _from_node,
            "ToEngine": _to_engine,
            "Clock": partial(_counter, CLOCK),
            "Iteration": partial(_counter, ITERATION),
            "InputDummy": _input_dummy,
            "OutputDummy": _output_dummy,
            "createFNFromFactoryModule": _refusal("createFNFromFactoryModule"),
            "node_policies": _POLICIES,
            **{name: _refusal(name) for name in _ELSEWHERE},
        }

    def _functional_node(
        self, name: str, outputs: Sequence[str] = (), exec_policy: str = ON_NEW_MESSAGE
    ) -> Callable[[Callable[..., Any]], Node]:
        def register(call: Callable[..., Any]) -> Node:
            node = Node(name, tuple(outputs), call, exec_policy == ALWAYS)
            self.registered.append(node)
            return node

        return register


def _from_engine(keyword: str, address: str, **_policies: Any) -> Callable[[Node], Node]:
    def ask(node: Node) -> Node:
        engine, name = _split(address, node)
        node.engines[keyword] = Identity(name, engine)
        return node

    return ask


def _from_node(keyword: str, address: str, **_policies: Any) -> Callable[[Node], Node]:
    def ask(node: Node) -> Node:
        node.nodes[keyword] = _split(address, node)
        return node

    return ask


def _to_engine(keyword: str, address: str) -> Callable[[Node], Node]:
    def send(node: Node) -> Node:
        node.targets[keyword] = address.strip("/")
        return node

    return send


def _counter(kind: str, keyword: str) -> Callable[[Node], Node]:
    def count(node: Node) -> Node:
        node.counters[keyword] = kind
        return node

    return count


def _input_dummy(keyword: str, _id: str, value: Any) -> Callable[[Node], Node]:
    def give(node: Node) -> Node:
        node.constants[keyword] = value
        return node

    return give


def _output_dummy(_keyword: str, _id: str) -> Callable[[Node], Node]:
    return lambda node: node


def _split(address: str, node: Node) -> tuple[str, str]:
    first, _, rest = address.strip("/").partition("/")
    if not rest:
        raise TransferFunctionError(
            f"the address of an input of '{node.name}' is '/name/item', not '{address}'"
        )
    return first, rest


def _refusal(name: str) -> Callable[..., NoReturn]:
    def refuse(*_given: Any, **_more: Any) -> NoReturn:
        raise TransferFunctionError(
            f"'{name}' of NRP-core 4 is not supported: nodes connect engines and nodes"
        )

    return refuse


def load_nodes(path: Path, scope: Scope, shared: ModuleType, decorators: NodeDecorators) -> list[Node]:
    """Execute a graph file in the module that all of them share, and return its nodes.

    Raises:
        TransferFunctionError: it raises, or registers none.
    """
    found = registered_by(path, scope, shared, decorators.registered)
    if not found:
        raise TransferFunctionError("the file registers no functional node", path=path)
    for node in found:
        node.path = path
    return found


class Graph:
    """Runs nodes.

    Args:
        nodes: the nodes, in the order of the files.

    Raises:
        TransferFunctionError: a node's input is no other node's output, or nodes wait for each other.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self._nodes = {node.name: node for node in nodes}
        self._last: dict[tuple[str, str], Any] = {}
        self._order: list[Node] = []
        self._needed: dict[str, set[str]] = {}
        for node in nodes:
            self._place(node, ())
        for node in nodes:
            for engine in node.targets.values():
                self._needed.setdefault(engine, set()).update(self._ancestors(node))

    def _place(self, node: Node, above: tuple[str, ...]) -> None:
        """Append a node to the order, after those that it depends on."""
        if node in self._order:
            return
        if node.name in above:
            raise TransferFunctionError(f"the nodes {', '.join(above)} wait for each other", path=node.path)
        for name, output in node.nodes.values():
            if name not in self._nodes or output not in self._nodes[name].outputs:
                known = [f"/{one.name}/{each}" for one in self._nodes.values() for each in one.outputs]
                message = f"no node returns '/{name}/{output}'{did_you_mean(f'/{name}/{output}', known)}"
                raise TransferFunctionError(message, path=node.path)
            self._place(self._nodes[name], (*above, node.name))
        self._order.append(node)

    def _ancestors(self, node: Node) -> set[str]:
        names = {node.name}
        for name, _ in node.nodes.values():
            names |= self._ancestors(self._nodes[name])
        return names

    def reset(self) -> None:
        """Delete the outputs of nodes."""
        self._last.clear()

    def run(
        self,
        engines: Sequence[str] | None,
        inputs: Mapping[Identity, DataPack],
        call: Callable[[Node, dict[str, Any]], Any],
        now: Mapping[str, int],
    ) -> dict[Identity, DataPack]:
        """Run the nodes that send to engines, and return the datapacks for engines.

        Args:
            engines: the engines that are due; None: run all nodes.
            inputs: the datapacks of engines.
            call: calls the function of a node with its arguments.
            now: the values of ``clock`` and ``iteration``.
        """
        needed = set(self._nodes) if engines is None else self._needed_by(engines)
        new: set[tuple[str, str]] = set()
        sent: dict[Identity, DataPack] = {}
        for node in self._order:
            if node.name not in needed:
                continue
            packs = {keyword: inputs[one] for keyword, one in node.engines.items()}
            is_new = any(pack.updated for pack in packs.values()) or not new.isdisjoint(node.nodes.values())
            if not (node.always or is_new or node.counters or node.constants):
                continue
            given: dict[str, Any] = dict.fromkeys(signature(node.call).parameters)  # None without an input
            given |= {keyword: now[kind] for keyword, kind in node.counters.items()} | node.constants
            given |= {keyword: pack.copy() for keyword, pack in packs.items()}
            given |= {keyword: self._last.get(one) for keyword, one in node.nodes.items()}
            for output, value in self._returned(node, call(node, given)):
                self._last[node.name, output] = value
                new.add((node.name, output))
                if output in node.targets and value is not None:
                    value.engine_name = node.targets[output]
                    sent[value.identity] = value
        return sent

    def _needed_by(self, engines: Sequence[str]) -> set[str]:
        return set().union(*(self._needed.get(name, set()) for name in engines))

    def _returned(self, node: Node, result: Any) -> Iterator[tuple[str, Any]]:
        if result is None:
            return
        if not isinstance(result, list | tuple) or len(result) != len(node.outputs):
            raise TransferFunctionError(
                f"the node '{node.name}' returns a list of {len(node.outputs)}, as its outputs, or None",
                path=node.path,
            )
        for output, value in zip(node.outputs, result, strict=True):
            if output in node.targets and value is not None and not isinstance(value, DataPack):
                message = f"'{output}' of '{node.name}' goes to an engine, so it must be a datapack"
                raise TransferFunctionError(message, path=node.path)
            yield output, value
