"""Uses of parameters."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core.checks.declared import Unread
from nrp_core.checks.events import Return
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.functions.mappings import MapSpikeSource
from nrp_core.dsl.functions.monitors import MonitoringFunction
from nrp_core.findings import Code, Finding, Level

_WIRING: Final = {"connector", "weight", "delay", "receptor_type", "synapse_type"}
"""Settings of a source that make no spikes."""


@checks_function(Code.NRP231)
def sources_are_set(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sources that a body never sets."""
    loads = [node for node in _names(function) if not isinstance(node.ctx, ast.Store)]
    used = {node.id for node in loads}
    only_read = _only_read(function)
    for name, mapping in function.function.mappings.items():
        if name in function.function.triggers or isinstance(mapping, Unread):
            continue
        drives = isinstance(mapping, MapSpikeSource)
        settings = set(mapping.options) - _WIRING if isinstance(mapping, MapSpikeSource) else ()
        node = function.declared.parameter(name)
        if drives and (name not in used or name in only_read) and not settings:
            message = f"nothing sets the source '{name}': it stays silent"
            yield function.declared.finding(Code.NRP231, node, message, Level.WARNING)


@checks_function(Code.NRP231)
def sources_have_weight(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sources whose spikes have no effect."""
    for name, mapping in function.function.mappings.items():
        weight = mapping.options.get("weight") if isinstance(mapping, MapSpikeSource) else None
        if isinstance(weight, (int, float)) and weight == 0:
            message = f"the weight of the source '{name}' is 0: its spikes have no effect"
            node = function.declared.parameter(name)
            yield function.declared.finding(Code.NRP231, node, message, Level.WARNING)


def _names(function: CheckedFunction) -> Iterator[ast.Name]:
    for statement in function.declared.node.body:
        yield from (node for node in ast.walk(statement) if isinstance(node, ast.Name))


def _only_read(function: CheckedFunction) -> set[str]:
    """Return the parameters whose attributes the body only reads; a method call may set them."""
    body = ast.Module(function.declared.node.body, [])
    parents = {id(child): node for node in ast.walk(body) for child in ast.iter_child_nodes(node)}
    other: set[str] = set()
    for name in _names(function):
        parent = parents.get(id(name))
        reads = isinstance(parent, ast.Attribute) and isinstance(parent.ctx, ast.Load)
        if not reads or isinstance(parents.get(id(parent)), (ast.Call, ast.Subscript)):
            other.add(name.id)
    return set(function.function.parameters) - other


@checks_function(Code.NRP237)
def returned_values_are_used(function: CheckedFunction) -> Iterator[Finding]:
    """Look for return values without a topic, and for topics that get none."""
    if not function.declared.is_read or isinstance(function.function, MonitoringFunction):
        return
    values = [event for event in function.events if isinstance(event, Return) and event.value is not None]
    topic, name = function.function.topic, function.function.name
    if topic is not None and not _returns(function):
        message = f"'{name}' returns nothing, so nothing is sent on '{topic.name}'"
        yield function.declared.finding(Code.NRP237, function.declared.node, message, Level.WARNING)
    if topic is None and values:
        is_message = isinstance(values[0].value, Instance) and hasattr(values[0].value.cls, "__msgtype__")
        level = Level.WARNING if is_message else Level.NOTE
        message = f"the return value of '{name}' is not used: it has no topic"
        yield function.declared.finding(Code.NRP237, values[0].node, message, level)


def _returns(function: CheckedFunction) -> bool:
    """Return whether a body returns a value anywhere, including code that is meant to fail."""
    for node in function.declared.own:
        if isinstance(node, ast.Return) and node.value is not None:
            return not (isinstance(node.value, ast.Constant) and node.value.value is None)
    return False
