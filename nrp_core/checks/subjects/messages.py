"""Messages that are not sent, sent in vain, or converted to nothing."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core.checks.code.declarations import found_in
from nrp_core.checks.code.syntax import SCOPES, excerpt, own_nodes, root_of
from nrp_core.checks.code.values import Instance, adapter_of, class_of, is_message
from nrp_core.checks.static_experiment import (
    CheckedFunction,
    StaticExperiment,
    checks_experiment,
    checks_function,
)
from nrp_core.dsl.monitors import MonitoringFunction
from nrp_core.dsl.parameters import PublishedTopic
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.base import type_name
from nrp_core.scripts import last_name

_WHOLE_STATE: Final = ("std_msgs/", "geometry_msgs/")
"""Packages whose messages hold the whole state of what they command."""
_REPEATING: Final = (ast.For, ast.AsyncFor, ast.While, *SCOPES)
"""Code by which a later change may be sent all the same."""


@checks_function
def check_return_values(function: CheckedFunction) -> Iterator[Finding]:
    """Look for return values without a topic, and for topics that get none."""
    if not function.declared.is_read or isinstance(function.function, MonitoringFunction):
        return
    topic, name = function.function.topic, function.function.name
    values = [
        one for one in reversed(function.declared.own) if isinstance(one, ast.Return) and not _is_bare(one)
    ]
    if topic is not None and not values:
        message = f"'{name}' returns nothing, so nothing is sent on '{topic.name}'"
        yield function.warning(Code.NRP237, function.declared.node, message)
    if topic is None and values:
        is_sent = is_message(class_of(function.body.shape(values[0].value)))
        message = f"the return value of '{name}' is not used: it has no topic"
        level = Level.WARNING if is_sent else Level.NOTE
        yield function.declared.finding(Code.NRP237, values[0], message, level)


def _is_bare(node: ast.Return) -> bool:
    return node.value is None or (isinstance(node.value, ast.Constant) and node.value.value is None)


@checks_function
def check_unsent_messages(function: CheckedFunction) -> Iterator[Finding]:
    """Look for messages that are made or filled and not sent."""
    own = function.declared.own
    for node in own:
        match node:
            case ast.Expr(ast.Call() as made) if _makes_message(function, made):
                message = f"the message '{excerpt(made)}' is made and not sent"
                yield function.warning(Code.NRP355, node, message)
            case ast.Assign([ast.Name(name) as target], ast.Call() as made) if _makes_message(function, made):
                if _is_only_filled(function, target):
                    message = f"the message '{name}' is filled and not sent"
                    yield function.warning(Code.NRP355, target, message)


def _makes_message(function: CheckedFunction, call: ast.Call) -> bool:
    found = function.body.shape(call)
    return isinstance(found, Instance) and is_message(found.cls)


def _is_only_filled(function: CheckedFunction, target: ast.Name) -> bool:
    """Return whether fields of a message are set and the message is not used otherwise."""
    nodes = list(ast.walk(function.declared.node))
    if any(isinstance(one, ast.Global | ast.Nonlocal) and target.id in one.names for one in nodes):
        return False
    parts = (one for one in nodes if isinstance(one, ast.Attribute | ast.Subscript))
    filled = {root_of(one) for one in parts if isinstance(one.ctx, ast.Store)}
    uses = [one for one in nodes if _is_name(one, target.id) and one is not target]
    return bool(uses) and filled.issuperset(uses)


@checks_function
def check_late_changes(function: CheckedFunction) -> Iterator[Finding]:
    """Look for fields that are set after the message was sent, and of a message that is not used again."""
    body = function.declared.node.body
    if any(isinstance(node, _REPEATING) for statement in body for node in ast.walk(statement)):
        return
    for place, statement in enumerate(body):
        match statement:
            case ast.Expr(ast.Call(ast.Attribute(owner, "send_message"), [ast.Name(name)])):
                uses = [one for later in body[place + 1 :] for one in ast.walk(later) if _is_name(one, name)]
                targets = [_filled_field(later) for later in body[place + 1 :]]
                changed = [one for one in targets if one is not None and root_of(one) in uses]
                is_sent = isinstance(adapter_of(function.body.shape(owner)), PublishedTopic)
                is_made = isinstance(function.body.name(name), Instance)
                if changed and len(uses) == len(changed) and is_sent and is_made:
                    text, line = ast.unparse(changed[0]), statement.lineno
                    message = (
                        f"'{text}' is set after '{name}' was sent in line {line}: the change is not sent"
                    )
                    yield function.warning(Code.NRP355, changed[0], message)


def _is_name(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def _filled_field(statement: ast.stmt) -> ast.Attribute | None:
    """Return the attribute that a statement sets."""
    match statement:
        case ast.Assign([ast.Attribute() as target]) | ast.AugAssign(ast.Attribute() as target):
            return target
    return None


@checks_function
def check_overwritten_messages(function: CheckedFunction) -> Iterator[Finding]:
    """Look for two messages on one topic in a sequence of statements that all run.

    Messages about several things, such as trajectories of some joints each, may follow each other.
    """
    topics = {
        name: mapping.writes.name
        for name, mapping in function.function.mappings.items()
        if mapping.writes is not None and _is_whole_state(function, mapping.writes.name)
    }
    for statements in _sequences(function.declared.node):
        first: dict[str, ast.Expr] = {}
        for statement in statements:
            match statement:
                case ast.Expr(ast.Call(ast.Attribute(ast.Name(name), "send_message"))) if name in topics:
                    if name in first:
                        message = (
                            f"line {statement.lineno} sends another message on '{topics[name]}': functions "
                            "and robots use only that one"
                        )
                        yield function.warning(Code.NRP319, first[name], message)
                    first[name] = statement
                case ast.Expr() | ast.Assign() | ast.AugAssign() | ast.AnnAssign():
                    pass
                case _:  # it may end the function
                    first.clear()


def _is_whole_state(function: CheckedFunction, topic: str) -> bool:
    served = function.world.topics.get(topic)
    return served is not None and type_name(served.type).startswith(_WHOLE_STATE)


def _sequences(function: ast.AST) -> Iterator[list[ast.stmt]]:
    """Yield all sequences of statements in a function."""
    for node in ast.walk(function):
        for _, part in ast.iter_fields(node):
            if isinstance(part, list) and part and isinstance(part[0], ast.stmt):
                yield part


@checks_experiment
def check_preprocessed_topics(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions of preprocessed topics that return nothing, so that ``value`` is None."""
    for source in [source for listing in static.listings for source in listing.sources]:
        nodes = list(ast.walk(source.tree))
        defined = {one.name: one for one in nodes if isinstance(one, ast.FunctionDef)}
        for node in nodes:
            match node:
                case ast.Call(func, [_, _, ast.Name(name), *_]) if name in defined:
                    returned = [one for one in own_nodes(defined[name].body) if isinstance(one, ast.Return)]
                    if last_name(func) == "PreprocessedTopic" and all(map(_is_bare, returned)):
                        message = (
                            f"'{name}' returns nothing, and its result is the message: it is always None"
                        )
                        yield found_in(source, Code.NRP356, node, message, Level.WARNING)
