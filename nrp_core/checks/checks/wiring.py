"""Parameters, variables, sources and topics of functions that contradict each other or that nothing sets."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from typing import Final

import numpy as np

from nrp_core.checks.code.declarations import Unread
from nrp_core.checks.code.shapes import Compute, Instance, Read, Return, Write
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapCSVRecorder, MapSpikeSource, MapVariable
from nrp_core.dsl.monitors import MonitoringFunction
from nrp_core.dsl.parameters import Adapter
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name

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


_PLAIN = (ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Expr, ast.Return)
_CHOOSING = (ast.IfExp, ast.BoolOp, ast.Lambda)
_UNCHANGING = (int, float, str, bool, type(None))
_COMPARABLE = (int, float, str, bool, tuple, list, dict)


@checks_function(Code.NRP210)
def shared_variables_are_global(function: CheckedFunction) -> Iterator[Finding]:
    """Look for variables that have a key for all functions and are local."""
    for name, node in _local(function):
        if any(one.arg == "global_key" for one in node.keywords):
            message = f"'{name}' is not shared: global_key has an effect only with scope=nrp.GLOBAL"
            yield function.declared.finding(Code.NRP210, node, message, Level.WARNING)


@checks_experiment(Code.NRP210)
def shared_variables_begin_once(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions that give different initial values to one shared variable."""
    first: dict[str, tuple[CheckedFunction, object]] = {}
    for function in static.functions:
        for name, mapping in function.function.mappings.items():
            if not isinstance(mapping, MapVariable) or mapping.global_key is None:
                continue
            key, value = mapping.global_key, mapping.initial_value
            if type(value) not in _COMPARABLE:  # there is none, or it depends on the brain
                continue
            other, initial = first.setdefault(key, (function, value))
            if initial != value:
                message = (
                    f"'{key}' starts as {initial!r:.40}, from '{other.function.name}', not as {value!r:.40}"
                )
                node = function.declared.nodes.get(name)
                yield function.declared.finding(Code.NRP210, node, message, Level.WARNING)


@checks_experiment(Code.NRP210)
def shared_variables_are_set_and_read(static: StaticExperiment) -> Iterator[Finding]:
    """Look for a shared variable that is only read beside another that is only set."""
    readers: dict[str, tuple[CheckedFunction, str]] = {}
    read, written = set[str](), set[str]()
    for function in static.functions:
        for event in function.events:
            if not (isinstance(event, Read | Write) and event.name == "value"):
                continue
            name = function.parameter_of(event.owner)
            mapping = None if name is None else function.function.mappings[name]
            if isinstance(mapping, MapVariable) and mapping.global_key is not None and name is not None:
                if type(mapping.initial_value) not in _UNCHANGING:
                    return
                (read if isinstance(event, Read) else written).add(mapping.global_key)
                readers.setdefault(mapping.global_key, (function, name))
    shared = [
        mapping
        for function in static.functions
        for mapping in function.function.mappings.values()
        if isinstance(mapping, MapVariable)
    ]
    plain = {one.global_key for one in shared if type(one.initial_value) in (int, float, str, bool)}
    mapped = Counter(one.global_key for one in shared)
    begun = {
        mapping.global_key
        for function in static.functions
        for name, mapping in function.function.mappings.items()
        if isinstance(mapping, MapVariable) and _begins(function.declared.nodes.get(name))
    }
    for key in sorted(
        read - written - begun if static.is_complete and written and not written - read else ()
    ):
        function, name = readers[key]
        message = f"nothing sets the shared variable '{key}', and it has no initial_value: it is always None"
        node = function.declared.nodes.get(name)
        yield function.declared.finding(Code.NRP210, node, message, Level.WARNING)
    alone = {key for key in (read - written) & plain if mapped[key] == 1}
    for key in sorted(alone if static.is_complete and not written - read else ()):
        function, name = readers[key]
        message = f"nothing sets the shared variable '{key}', and no other function has it: it never changes"
        node = function.declared.nodes.get(name)
        yield function.declared.finding(Code.NRP210, node, message, Level.WARNING)
    for key in sorted(read - written if static.is_complete and written - read else ()):
        function, name = readers[key]
        others = ", ".join(map(repr, sorted(written - read)))
        message = f"nothing sets the shared variable '{key}', and nothing reads {others}; is one name meant?"
        yield function.declared.finding(
            Code.NRP210, function.declared.nodes.get(name), message, Level.WARNING
        )


@checks_function(Code.NRP247)
def variables_begin_with_a_value(function: CheckedFunction) -> Iterator[Finding]:
    """Look for variables without an initial value that are used in a computation in the first run."""
    computed = {_place(event.node): event.node for event in function.events if isinstance(event, Compute)}
    for name, node in _local(function):
        if len(node.args) > 1 or any(one.arg in ("initial_value", None) for one in node.keywords):
            continue
        uses = (_uses(one, name) for one in function.declared.node.body)
        first = next((found for found in uses if found is not None), [])
        wrong = next((computed[_place(one)] for one in first if _place(one) in computed), None)
        if wrong is not None:
            message = f"'{name}.value' is None in the first run: give it an initial_value"
            yield function.declared.finding(Code.NRP247, wrong, message)


def _local(function: CheckedFunction) -> Iterator[tuple[str, ast.Call]]:
    for name, mapping in function.function.mappings.items():
        node = function.declared.nodes.get(name)
        if isinstance(mapping, MapVariable) and mapping.global_key is None and isinstance(node, ast.Call):
            yield name, node


def _begins(decorator: ast.AST | None) -> bool:
    """Return whether a variable is given an initial value, which may be known only when the file runs."""
    if not isinstance(decorator, ast.Call):
        return True
    return len(decorator.args) > 1 or any(
        one.arg in ("initial_value", None) and ast.unparse(one.value) != "None" for one in decorator.keywords
    )


def _place(node: ast.expr) -> tuple[int, int, str]:
    """Return a key that is equal for the read and the assignment of ``n.value`` in ``n.value += 1``."""
    return node.lineno, node.col_offset, ast.unparse(node)


def _uses(statement: ast.stmt, name: str) -> list[ast.expr] | None:
    """Return where a statement certainly reads a variable's value; None without such a place."""
    parts = list(ast.walk(statement))
    if not any(isinstance(one, ast.Name) and one.id == name for one in parts):
        return None
    sure = isinstance(statement, _PLAIN) and not any(isinstance(one, _CHOOSING) for one in parts)
    values = [one for one in parts if isinstance(one, ast.Attribute) and ast.unparse(one) == f"{name}.value"]
    return list(values) if sure else []


@checks_experiment(Code.NRP330)
def shared_variables_are_shared_by_both(static: StaticExperiment) -> Iterator[Finding]:
    """Look for a variable that one function sets for all and another reads as its own."""
    uses = [
        (
            function,
            name,
            mapping,
            [one for one in _nodes(function.declared.node.body) if _is_value(one, name)],
        )
        for function in static.functions
        for name, mapping in function.function.mappings.items()
        if isinstance(mapping, MapVariable)
    ]
    set_ = {mapping.global_key for *_, mapping, nodes in uses if any(_is_stored(one) for one in nodes)}
    read = {mapping.global_key for *_, mapping, nodes in uses if not all(_is_stored(one) for one in nodes)}
    for function, name, mapping, nodes in uses:
        is_set = any(_is_stored(one) for one in nodes)
        if mapping.global_key is None and nodes and not is_set and name in set_ - read:
            message = f"nothing sets this '{name}': another function sets the one with scope=nrp.GLOBAL"
            node = function.declared.nodes.get(name)
            yield function.declared.finding(Code.NRP330, node, message, Level.WARNING)
    own = {
        (function.function.name, name): [_is_stored(one) for one in nodes]
        for function, name, mapping, nodes in uses
        if mapping.global_key is None and nodes
    }
    only_set = {name: setter for (setter, name), stored in own.items() if all(stored)}
    for function, name, *_ in uses:
        if name in only_set and not any(own.get((function.function.name, name), [True])):
            message = (
                f"nothing sets this '{name}': '{only_set[name]}' sets another of its own; "
                "scope=nrp.GLOBAL in both makes it one"
            )
            node = function.declared.nodes.get(name)
            yield function.declared.finding(Code.NRP330, node, message, Level.WARNING)


def _nodes(body: list[ast.stmt]) -> list[ast.AST]:
    return [node for one in body for node in ast.walk(one)]


def _is_value(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Attribute) and ast.unparse(node) == f"{name}.value"


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load)


@checks_experiment(Code.NRP279)
def settings_have_an_effect(static: StaticExperiment) -> Iterator[Finding]:
    """Look for settings of images without a camera, and of CSV files without a recorder."""
    experiment = static.experiment
    own = experiment.source.place.path
    for keys, message in _idle(static):
        place, found = experiment.source.nearest(keys)
        if found == keys and place.place.path in (None, own):  # a file that it extends is for others, too
            yield place.place.finding(Code.NRP279, message, Level.WARNING)


def _idle(static: StaticExperiment) -> Iterator[tuple[tuple[Key, ...], str]]:
    """Yield the keys of each setting without effect, with the message about it."""
    scene, robots = static.scene, static.experiment.world.robots
    models = {} if scene is None else {model.name: model for model in scene.models}
    sensors = [sensor for model in models.values() for link in model.links for sensor in link.sensors]
    if models.keys() >= robots.keys() and not any(sensor.views for sensor in sensors):
        for name in ("image_scale", "renderer"):
            yield ("world", "options", name), f"'{name}' has no effect: no robot has a camera"
    mappings = [one for each in static.declared for one in each.function.mappings.values()]
    if static.is_complete and not any(isinstance(one, MapCSVRecorder) for one in mappings):
        yield ("csv_folder",), "'csv_folder' has no effect: no function has a CSV recorder"


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


@checks_experiment(Code.NRP229)
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
            yield declared.finding(Code.NRP229, node, message, Level.WARNING)


def _neurons(adapter: Adapter) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    devices = list(adapter) if isinstance(adapter, DeviceGroup) else [adapter]
    ids = [device.selection.ids for device in devices if isinstance(device, Device)]
    return np.concatenate([np.empty(0, dtype=np.int64), *ids])
