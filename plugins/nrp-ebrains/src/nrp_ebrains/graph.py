"""Computational graphs: nodes receive datapacks from engines and other nodes, and send some to engines.

The graph runs before each step of an engine, driven by its outputs: only nodes run from which a path leads to
an engine that is due. Of these, a node runs if one of its inputs is new, or always if it says so. Topics of
MQTT connect the nodes of one graph, without a broker; those of an engine are its datapacks.
"""

# ruff: noqa: A002 - the names of NRP-core 4
from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from functools import partial
from inspect import signature
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NoReturn

from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.scripts import Scope
from nrp_ebrains.datapacks import DataPack, Identity, JsonData
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
_ELSEWHERE = "RosSubscriber", "RosPublisher", "FromSpinnaker", "ToSpinnaker"
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
        subscribed: the topic and type of each keyword that receives messages of nodes.
        published: the topic on which an output is published.
        periods: how many iterations of an output-driven event loop an output is computed after.
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
    subscribed: dict[str, tuple[str, type]] = field(default_factory=dict)
    published: dict[str, str] = field(default_factory=dict)
    periods: dict[str, int] = field(default_factory=dict)
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

    Args:
        engines: the names of engines, whose topics are their datapacks.

    Attributes:
        registered: the nodes so far.
    """

    def __init__(self, engines: Collection[str]) -> None:
        self.registered: list[Node] = []
        self._engines = engines

    def names(self) -> Mapping[str, Any]:
        """Return the names that ``from nrp_core.event_loop import *`` gives a file."""
        return {
            "FunctionalNode": self._functional_node,
            "FromEngine": _from_engine,
            "FromFunctionalNode": lambda keyword, address, **_: _attach("nodes", keyword, _split(address)),
            "ToEngine": partial(_output, "targets"),
            "MQTTSubscriber": self._subscriber,
            "MQTTPublisher": self._publisher,
            "Clock": lambda keyword: _attach("counters", keyword, CLOCK),
            "Iteration": lambda keyword: _attach("counters", keyword, ITERATION),
            "InputDummy": lambda keyword, _id, value: _attach("constants", keyword, value),
            "OutputDummy": lambda keyword, _id, compute_period=1, **_: _period(keyword, compute_period),
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

    def _subscriber(self, keyword: str, address: str, type: type, **_policies: Any) -> Callable[[Node], Node]:
        engine, _, name = address.partition("/get/")
        if name and engine in self._engines:
            return _attach("engines", keyword, Identity(name, engine))
        return _attach("subscribed", keyword, (address, type))

    def _publisher(
        self, keyword: str, address: str, type: object = None, **policies: Any
    ) -> Callable[[Node], Node]:
        engine, _, name = address.partition("/set/")
        if name and engine in self._engines:
            return _output("targets", keyword, engine, **policies)
        return _output("published", keyword, address, **policies)


def _attach(table: str, keyword: str, value: Any) -> Callable[[Node], Node]:
    """Return a decorator that adds an entry to a table of a node."""

    def attach(node: Node) -> Node:
        getattr(node, table)[keyword] = value
        return node

    return attach


def _from_engine(keyword: str, address: str, **_policies: Any) -> Callable[[Node], Node]:
    engine, name = _split(address)
    return _attach("engines", keyword, Identity(name, engine))


def _output(
    table: str, keyword: str, address: str, compute_period: int = 1, **_policies: Any
) -> Callable[[Node], Node]:
    count, send = _period(keyword, compute_period), _attach(table, keyword, address.strip("/"))
    return lambda node: send(count(node))


def _period(keyword: str, iterations: int) -> Callable[[Node], Node]:
    if iterations < 1:
        raise TransferFunctionError(f"'{keyword}' has compute_period {iterations}, which must be at least 1")
    return _attach("periods", keyword, iterations)


def _split(address: str) -> tuple[str, str]:
    first, _, rest = address.strip("/").partition("/")
    if not rest:
        raise TransferFunctionError(f"the address of an input is '/name/item', not '{address}'")
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
        self._messages: dict[str, Any] = {}
        self._sent: dict[str, Any] = {}
        self._due: set[str] = set()  # the names of nodes with new inputs
        self._readers: dict[object, set[str]] = {}
        self._order: list[Node] = []
        for node in nodes:
            self._place(node, ())
            for source in (*node.nodes.values(), *(topic for topic, _ in node.subscribed.values())):
                self._readers.setdefault(source, set()).add(node.name)

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
        """Delete the outputs of nodes, and their messages."""
        for kept in (self._last, self._messages, self._sent, self._due):
            kept.clear()

    def needed_by(self, engines: Collection[str]) -> set[str]:
        """Return the names of the nodes from which a path leads to engines."""
        return self._all_ancestors(one for one in self._order if set(engines) & set(one.targets.values()))

    def needed_at(self, iteration: int) -> set[str]:
        """Return the names of the nodes that outputs need in an iteration of an output-driven event loop."""
        due = (one for one in self._order if any(iteration % each == 0 for each in one.periods.values()))
        return self._all_ancestors(due)

    def _all_ancestors(self, nodes: Iterable[Node]) -> set[str]:
        return set().union(*map(self._ancestors, nodes))

    def run(
        self,
        needed: Collection[str] | None,
        inputs: Mapping[Identity, DataPack],
        call: Callable[[Node, dict[str, Any]], Any],
        now: Mapping[str, int],
    ) -> dict[Identity, DataPack]:
        """Run nodes, and return the datapacks for engines; messages arrive in the next run.

        Args:
            needed: the names of the nodes; None: run all nodes.
            inputs: the datapacks of engines.
            call: calls the function of a node with its arguments.
            now: the values of ``clock`` and ``iteration``.
        """
        arrived, self._sent = self._sent, {}
        self._messages |= arrived
        self._due.update(*(self._readers.get(topic, ()) for topic in arrived))
        sent: dict[Identity, DataPack] = {}
        for node in self._order:
            if needed is not None and node.name not in needed:
                continue
            packs = {keyword: inputs[one] for keyword, one in node.engines.items()}
            is_new = node.name in self._due or any(pack.updated for pack in packs.values())
            if not (node.always or is_new or node.counters or node.constants):
                continue
            self._due.discard(node.name)
            given: dict[str, Any] = dict.fromkeys(signature(node.call).parameters)  # None without an input
            given |= {keyword: now[kind] for keyword, kind in node.counters.items()} | node.constants
            given |= {keyword: pack.copy() for keyword, pack in packs.items()}
            given |= {keyword: self._last.get(one) for keyword, one in node.nodes.items()}
            given |= {keyword: self._message(node, *one) for keyword, one in node.subscribed.items()}
            for output, value in self._returned(node, call(node, given)):
                self._last[node.name, output] = value
                self._due |= self._readers.get((node.name, output), set())
                if output in node.published:
                    self._sent[node.published[output]] = deepcopy(value)
                if output in node.targets and value is not None:
                    value.engine_name = node.targets[output]
                    sent[value.identity] = value
        return sent

    def _message(self, node: Node, topic: str, kind: type) -> Any:
        """Return the last message of a topic as a type, or None."""
        message = self._messages.get(topic)
        if kind is JsonData and isinstance(message, str):
            try:
                return JsonData(json.loads(message))
            except ValueError as error:
                text = f"the message on '{topic}' for the node '{node.name}' is not JSON: {error}"
                raise TransferFunctionError(text, path=node.path) from error
        return str(message) if kind is str and message is not None else message

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
