"""The row of a transfer function that is made of building blocks."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_bibi.diagram.rows import Device, Row, Topic, wrapped
from nrp_bibi.generation.expressions import as_python
from nrp_bibi.generation.selectors import selection
from nrp_bibi.generation.walk import channels, parts
from nrp_bibi.model.channels import AnyDevice, TopicChannel
from nrp_bibi.model.functions import BIBITransferFunction
from nrp_bibi.model.selectors import NeuronSelector, NeuronSelectorTemplate


def row_of_blocks(function: BIBITransferFunction) -> Row:
    """Return the row of a transfer function."""
    returned = getattr(function, "return_value", None)
    every = [*channels(function), *([returned] if isinstance(returned, TopicChannel) else [])]
    return Row(
        f"{function.name}  ({type(function).__name__})",
        [line for text in _statements(function) for line in wrapped(text)],
        [_device(channel) for channel in every if isinstance(channel, AnyDevice)],
        [_topic(channel) for channel in every if isinstance(channel, TopicChannel)],
    )


def _device(channel: AnyDevice) -> Device:
    neurons = selection(channel.neurons).replace("nrp.brain.", "").replace("nrp.", "")
    named = (
        part for part in parts(channel.neurons) if isinstance(part, (NeuronSelector, NeuronSelectorTemplate))
    )
    population = ", ".join(dict.fromkeys(part.population for part in named if part.population))
    return Device(channel.name, channel.type.dsl_name, neurons, population, channel.body is not None)


def _topic(channel: TopicChannel) -> Topic:
    return Topic(channel.topic, channel.type.replace(".msg.", "/"), channel.body is not None)


def _statements(function: BIBITransferFunction) -> Iterator[str]:
    """Yield one line for each action of a transfer function, in order of execution."""
    for local in function.local:
        yield f"{local.name} = {ast.unparse(as_python(local.body))}"
    for channel in sorted(channels(function), key=lambda one: isinstance(one, TopicChannel)):
        if channel.body is not None:
            is_device = isinstance(channel, AnyDevice)
            written = f"{channel.name}.{channel.type.default_property}" if is_device else channel.name
            yield f"{written} = {ast.unparse(as_python(channel.body))}"
    returned = getattr(function, "return_value", None)
    if isinstance(returned, TopicChannel) and returned.body is not None:
        yield f"return {ast.unparse(as_python(returned.body))}"
