"""Received messages that are changed, or asked for joints and angles that they do not have."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import Final

from nrp_core.checks.declared import found_in
from nrp_core.checks.events import Read
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import Instance
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions.mappings import MapRobotSubscriber
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.gazebo_msgs import ModelStates

_CHANGING: Final = (
    "sort",
    "reverse",
    "append",
    "extend",
    "insert",
    "remove",
    "pop",
    "clear",
    "fill",
    "resize",
)
"""Methods that change a list or an array in place."""


@checks_function(Code.NRP300)
def received_messages_stay(function: CheckedFunction) -> Iterator[Finding]:
    """Look for received messages that are changed and not sent on."""
    received = _received(function)
    nodes = function.declared.own
    passed = {
        received[text] for node in nodes for one in _given(node) if (text := ast.unparse(one)) in received
    }
    for node in nodes:
        match node:
            case ast.Assign([target]) | ast.AugAssign(target):
                whole = _message_of(target, received)
                if whole and received[whole] not in passed:
                    message = (
                        f"'{excerpt(target)}' is part of a received message: changing it moves "
                        "nothing; send a message on a topic of commands"
                    )
                    yield function.declared.finding(Code.NRP300, target, message, Level.WARNING)
            case ast.Expr(ast.Call(ast.Attribute(ast.Attribute() | ast.Subscript() as part, method))):
                if method in _CHANGING and _message_of(part, received):
                    message = (
                        f"'{excerpt(node)}' changes the received message, which other functions get "
                        "as well: change a copy"
                    )
                    yield function.declared.finding(Code.NRP300, node, message, Level.WARNING)


@checks_experiment(Code.NRP332)
def joints_of_messages_exist(static: StaticExperiment) -> Iterator[Finding]:
    """Look for names of joints that the messages of a robot do not have."""
    if static.scene is None:
        return
    joints = {
        one.joint_states_topic: [
            *(joint.name for joint in one.joints),
            *(pair.name for pair in one.pair_controllers),
        ]
        for one in static.scene.models
        if one.joint_states_topic is not None
    }
    aliases = static.experiment.aliases
    for function in static.functions:
        received = _received(function)
        for node in function.declared.own:
            match node:
                case ast.Call(
                    ast.Attribute(ast.Attribute(owner, "name"), "index"), [ast.Constant(str() as name)]
                ) | ast.Compare(
                    ast.Constant(str() as name), [ast.In() | ast.NotIn()], [ast.Attribute(owner, "name")]
                ):
                    topic = received.get(ast.unparse(owner), "")
                    known = joints.get(aliases.get(topic, topic))
                    if known is not None and name not in known:
                        message = f"'{topic}' has no joint '{name}'{did_you_mean(name, known)}"
                        yield function.declared.finding(Code.NRP332, node, message, Level.WARNING)


@checks_experiment(Code.NRP320)
def places_in_states_are_of_moving_models(static: StaticExperiment) -> Iterator[Finding]:
    """Look for the state of a model by its place in a message, where a model is that never moves."""
    if static.scene is None or not static.is_complete:
        return
    models = static.scene.models
    for function in static.functions:
        read = {id(one.node) for one in function.events if isinstance(one, Read) and _is_of_states(one)}
        for node in function.declared.own:
            match node:
                case ast.Subscript(part, ast.Constant(int() as index)) if id(part) in read:
                    if index < len(models) and models[index].static:
                        message = (
                            f"'{excerpt(node)}' is that of '{models[index].name}', which is static; "
                            "msg.name.index('...') gives the place of a model"
                        )
                        yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


def _is_of_states(read: Read) -> bool:
    return read.owner == Instance(ModelStates) and read.name in ("pose", "twist")


@checks_experiment(Code.NRP300)
def preprocessed_messages_are_returned(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions of preprocessed topics that return nothing, so that ``value`` is None."""
    for source in [source for listing in static.listings for source in listing.sources]:
        defined = {one.name: one for one in ast.walk(source.tree) if isinstance(one, ast.FunctionDef)}
        for node in ast.walk(source.tree):
            match node:
                case ast.Call(func, [_, _, ast.Name(name), *_]) if name in defined:
                    returned = [one for one in own_nodes(defined[name].body) if isinstance(one, ast.Return)]
                    if ast.unparse(func).endswith("PreprocessedTopic") and not any(
                        one.value is not None for one in returned
                    ):
                        message = (
                            f"'{name}' returns nothing, and its result is the message: it is always None"
                        )
                        yield found_in(source, Code.NRP300, node, message, Level.WARNING)


def _given(node: ast.AST) -> list[ast.expr]:
    """Return the values that a piece of code passes on as they are."""
    match node:
        case ast.Call(_, args, keywords):
            return [*args, *(one.value for one in keywords)]
        case ast.Return(ast.expr() as value) | ast.Yield(ast.expr() as value):
            return [value]
        case ast.Assign([ast.Attribute() | ast.Subscript(), *_], value):
            return [value]
        case ast.Tuple(elts) | ast.List(elts):
            return elts
    return []


def _received(function: CheckedFunction) -> dict[str, str]:
    """Return the topics of the expressions that are received messages: ``camera.value`` and its aliases."""
    mappings = function.function.mappings
    found = {
        f"{name}.value": one.reads.name
        for name, one in mappings.items()
        if isinstance(one, MapRobotSubscriber)
    }
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Name(alias)], ast.Attribute() as value) if ast.unparse(value) in found:
                found[alias] = found[ast.unparse(value)]
    return found


def _message_of(target: ast.expr, received: Mapping[str, str]) -> str:
    """Return the received message of which an expression is a part; empty if there is none."""
    while isinstance(target, ast.Attribute | ast.Subscript):
        target = target.value
        if (text := ast.unparse(target)) in received:
            return text
    return ""
