"""Walk through transfer functions: their channels, their expressions, all their parts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nrp_bibi.model.channels import AnyDevice
from nrp_bibi.model.expressions import FlowExpression
from nrp_bibi.model.functions import BIBITransferFunction, ChannelTransferFunction, Neuron2Monitor
from nrp_bibi.model.metamodel import Node, features


def channels(function: BIBITransferFunction) -> list[Any]:
    """Return the channels of a transfer function, in the order of its parameters."""
    match function:
        case ChannelTransferFunction(topic=topics, device=own, device_group=groups, return_value=returned):
            more = [returned] if isinstance(returned, AnyDevice) else []
            return [*topics, *own, *more, *groups]
        case Neuron2Monitor(device=device):
            return [device]
        case _:
            return []


def bodies(function: BIBITransferFunction) -> Iterator[FlowExpression]:
    """Yield every expression of a transfer function; the return value comes last."""
    returned = getattr(function, "return_value", None)
    for channel in (*channels(function), returned):
        if channel is not None and channel.body is not None:
            yield channel.body


def parts(node: Node) -> Iterator[Node]:
    """Yield a node and everything below it."""
    yield node
    for feature in features(type(node)):
        value = getattr(node, feature.field)
        for one in value if feature.many else (value,):
            if isinstance(one, Node):
                yield from parts(one)
