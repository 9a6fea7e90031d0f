"""Find names of a model that would hide the functions and modules that its generated Python uses."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_bibi.generation.expressions import FUNCTIONS, in_framework
from nrp_bibi.generation.walk import channels, parts
from nrp_bibi.model.channels import TopicChannel
from nrp_bibi.model.expressions import Call, Operator
from nrp_bibi.model.functions import Bibi, BIBITransferFunction
from nrp_bibi.model.metamodel import Node
from nrp_bibi.model.selectors import MapSelector


def hidden(model: Bibi) -> Iterator[tuple[Node, str, Node]]:
    """Yield each node that hides a Python name, that name, and the node that uses it.

    A call through a channel or a local, such as ``state.level``, hides nothing: it is a method call.
    """
    functions = [one for one in model.transfer_function if isinstance(one, BIBITransferFunction)]
    used = {name: part for function in functions for name, part in _used(function)}
    for function in functions:
        if function.name in used:
            yield function, function.name, used[function.name]
        operators = dict(_operators(function))
        for channel in (*channels(function), *function.local):
            if channel.name in operators:
                yield channel, channel.name, operators[channel.name]
        before: dict[str, Node] = {}
        for local in function.local:
            before |= dict(_used(local.body))
            if local.name in before:
                yield local, local.name, before[local.name]


def _used(node: Node) -> Iterator[tuple[str, Node]]:
    """Yield the global names that the Python of a node uses, and the part that uses each."""
    yield from _operators(node)
    for part in parts(node):
        if isinstance(part, (Call, TopicChannel)):
            yield in_framework(part.type).partition(".")[0], part
        if isinstance(part, MapSelector):
            yield "range", part


def _operators(node: Node) -> Iterator[tuple[str, Node]]:
    for part in parts(node):
        if isinstance(part, Operator) and type(part) in FUNCTIONS:
            yield FUNCTIONS[type(part)], part
