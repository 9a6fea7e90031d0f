"""Conflicts between transfer functions: names, topics and neurons that two of them use."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import combinations

import numpy as np

from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.functions.mappings import MapSpikeSource
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name

_OF_ONE_THING = ("std_msgs/", "geometry_msgs/")
"""Packages whose messages hold the whole state of what they command."""


@checks_experiment(Code.NRP229)
def topics_have_one_writer(static: StaticExperiment) -> Iterator[Finding]:
    """Look for topics that two functions publish on, or one function twice."""
    first: dict[str, tuple[TransferFunction, str]] = {}
    for examined in static.functions:
        function = examined.function
        written = {(topic.name, "") for topic in [function.topic] if topic is not None}
        written |= {
            (mapping.writes.name, name) for name, mapping in function.mappings.items() if mapping.writes
        }
        if not function.active:
            continue
        for topic, parameter in sorted(written):
            other, _ = found = first.setdefault(topic, (function, parameter))
            if found != (function, parameter):
                twice = f"'{function.name}' publishes on '{topic}' twice"
                also = f"'{function.name}' publishes on '{topic}', as '{other.name}' does"
                message = twice if other is function else also
                node = examined.declared.nodes.get(parameter)
                yield examined.declared.finding(Code.NRP229, node, message, Level.WARNING)


@checks_function(Code.NRP319)
def messages_are_not_overwritten(function: CheckedFunction) -> Iterator[Finding]:
    """Look for two messages on one topic in a sequence of statements that all run.

    Messages about several things, such as trajectories of some joints each, may follow each other.
    """
    whole = {
        name: mapping.writes.name
        for name, mapping in function.function.mappings.items()
        if mapping.writes is not None and _is_of_one_thing(function, mapping.writes.name)
    }
    for loop in function.declared.own:
        for node in loop.body if isinstance(loop, ast.For | ast.While) else ():
            match node:
                case ast.Expr(ast.Call(ast.Attribute(ast.Name(name), "send_message"))) if name in whole:
                    message = (
                        f"this loop sends many messages on '{whole[name]}': functions and robots use only "
                        "the last one"
                    )
                    yield function.declared.finding(Code.NRP319, node, message, Level.WARNING)
    for statements in _sequences(function.declared.node):
        first: dict[str, ast.Expr] = {}
        for statement in statements:
            match statement:
                case ast.Expr(ast.Call(ast.Attribute(ast.Name(name), "send_message"))) if name in whole:
                    if name in first:
                        line = statement.lineno
                        message = (
                            f"line {line} sends another message on '{whole[name]}': functions and robots "
                            "use only that one"
                        )
                        yield function.declared.finding(Code.NRP319, first[name], message, Level.WARNING)
                    first[name] = statement
                case ast.Expr() | ast.Assign() | ast.AugAssign() | ast.AnnAssign():
                    pass
                case _:  # it may end the function
                    first.clear()


def _is_of_one_thing(function: CheckedFunction, topic: str) -> bool:
    served = function.world.topics.get(topic)
    return served is not None and type_name(served.type).startswith(_OF_ONE_THING)


def _sequences(function: ast.AST) -> Iterator[list[ast.stmt]]:
    """Yield all sequences of statements in a function."""
    for node in ast.walk(function):
        for _, part in ast.iter_fields(node):
            if isinstance(part, list) and part and isinstance(part[0], ast.stmt):
                yield part


@checks_experiment(Code.NRP230)
def neurons_have_one_source_of_a_kind(static: StaticExperiment) -> Iterator[Finding]:
    """Look for sources of the same kind that drive the same neurons."""
    sources = [
        (examined.declared, name, mapping, _neurons(examined.adapters[name]))
        for examined in static.functions
        for name, mapping in examined.function.mappings.items()
        if isinstance(mapping, MapSpikeSource) and name in examined.adapters and examined.function.active
    ]
    for (owner, first, one, ids), (declared, second, other, others) in combinations(sources, 2):
        both = np.intersect1d(ids, others)
        if one.kind is other.kind and both.size:
            where = f"'{first}'" + ("" if owner is declared else f" of '{owner.function.name}'")
            message = f"'{second}' drives neurons that {where} also drives: {other.selector!r}"
            node = declared.nodes.get(second)
            yield declared.finding(Code.NRP230, node, message, Level.WARNING)


def _neurons(adapter: Adapter) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    devices = list(adapter) if isinstance(adapter, DeviceGroup) else [adapter]
    ids = [device.selection.ids for device in devices if isinstance(device, Device)]
    return np.concatenate([np.empty(0, dtype=np.int64), *ids])
