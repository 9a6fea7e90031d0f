"""Attributes of devices, topics, variables and modules that function bodies read and set."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from types import ModuleType

from nrp_core.checks.events import Read, Write, missing_name
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Known, Names, Number, Row, can_set, names_of
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.devices.devices import Device, attribute_hint
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.functions.variables import Variable
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.parameters.topics import PublishedTopic, SubscribedTopic
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name


@checks_function(Code.NRP223)
def adapters_have_the_attribute(function: CheckedFunction) -> Iterator[Finding]:
    """Look for attributes that a parameter's device, topic or variable does not have."""
    for event in function.events:
        if isinstance(event, (Read, Write)) and not event.exists and _adapter(event) is not None:
            hint = attribute_hint(event.name, names_of(event.owner))
            message = f"{_described(function, event)} has no attribute '{event.name}'{hint}"
            yield function.declared.finding(Code.NRP223, event.node, message, instead=hint.instead)


@checks_function(Code.NRP223)
def numbers_have_no_attributes(function: CheckedFunction) -> Iterator[Finding]:
    """Look for attributes of numbers, such as those of the device that a number was read from."""
    for event in function.events:
        if isinstance(event, (Read, Write)) and not event.exists and isinstance(event.owner, Number):
            message = f"'{ast.unparse(event.node.value)}' is a number and has no '{event.name}'"
            yield function.declared.finding(Code.NRP223, event.node, message)


@checks_function(Code.NRP226)
def messages_have_the_field(function: CheckedFunction) -> Iterator[Finding]:
    """Look for fields that a message does not have."""
    for event in function.events:
        if isinstance(event, (Read, Write)) and not event.exists and isinstance(event.owner, Instance):
            hint = did_you_mean(event.name, names_of(event.owner))
            message = f"{type_name(event.owner.cls)} has no field '{event.name}'{hint}"
            yield function.declared.finding(Code.NRP226, event.node, message, instead=hint.instead)


@checks_function(Code.NRP241)
def modules_have_the_name(function: CheckedFunction) -> Iterator[Finding]:
    """Look for names that a module does not have."""
    for event in function.events:
        match event:
            case Read(node, Known(ModuleType()) | Names(), _, False):
                message, instead = missing_name(event)
                yield function.declared.finding(Code.NRP241, node, message, instead=instead)


@checks_function(Code.NRP224)
def only_writable_attributes_are_set(function: CheckedFunction) -> Iterator[Finding]:
    """Look for read-only attributes that are set."""
    for event in function.events:
        adapter = _adapter(event) if isinstance(event, Write) and event.exists else None
        if adapter is not None and isinstance(event, Write) and not can_set(adapter, event.name):
            level = Level.WARNING if isinstance(adapter, SubscribedTopic) else Level.ERROR
            message = f"{_described(function, event).rstrip(',')}: '{event.name}' is read-only"
            yield function.declared.finding(Code.NRP224, event.node, message, level)


@checks_function(Code.NRP225)
def settings_are_in_range(function: CheckedFunction) -> Iterator[Finding]:
    """Assign constants to a device that is not connected, to find invalid ones."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup() as device), name, True, Known(value)):
                pass
            case Write(node, Known(Device() | DeviceGroup() as device), name, True, Row(items)) if all(
                isinstance(item, Known) for item in items
            ):
                value = [item.value for item in items if isinstance(item, Known)]
            case _:
                continue
        if not can_set(device, name) or isinstance(value, Adapter):
            continue
        before = getattr(device, name)
        try:
            setattr(device, name, value)
            setattr(device, name, before)
        except (ValueError, TypeError) as error:
            plain = isinstance(value, (int, float, list, tuple))
            message = str(error) if plain else f"'{name}' takes a number, not {value!r:.40}"
            yield function.declared.finding(Code.NRP225, node, message)


def _adapter(event: Read | Write) -> Adapter | None:
    owner = event.owner.value if isinstance(event.owner, Known) else None
    return owner if isinstance(owner, Adapter) else None


def _described(function: CheckedFunction, event: Read | Write) -> str:
    """Return a short description of a parameter."""
    adapter = _adapter(event)
    name = function.parameter_of(event.owner)
    mapping = function.function.mappings.get(name or "")
    if isinstance(mapping, (MapSpikeSink, MapSpikeSource)):
        side = "source" if mapping.drives else "sink"
        group = "group of " if isinstance(adapter, DeviceGroup) else ""
        return f"'{name}', a {group}{mapping.kind} ({side}),"
    kinds = {
        SubscribedTopic: "a subscribed topic",
        PublishedTopic: "a published topic",
        Variable: "a variable",
    }
    text = next((text for kind, text in kinds.items() if isinstance(adapter, kind)), "")
    if name is None:
        return text or f"a {type(adapter).__name__}"
    return f"'{name}', {text}," if text else f"'{name}'"
