"""Messages that are made or filled and not sent."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.declared import Function
from nrp_core.checks.events import Call
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.scopes import SCOPES, own_nodes
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.checks.used import root_of
from nrp_core.findings import Code, Finding, Level

_PARTS = (ast.Attribute, ast.Subscript)


@checks_function(Code.NRP355)
def messages_are_sent(function: CheckedFunction) -> Iterator[Finding]:
    """Look for messages that are made or filled and not sent."""
    messages = {
        id(event.node)
        for event in function.events
        if isinstance(event, Call) and isinstance(event.callee, Known) and _is_message(event.callee.value)
    }
    for node in function.declared.own:
        if isinstance(node, ast.Expr) and id(node.value) in messages:
            message = f"the message '{excerpt(node.value)}' is made and not sent"
            yield function.declared.finding(Code.NRP355, node, message, Level.WARNING)
    for target in _filled(function.declared.node, messages):
        message = f"the message '{target.id}' is filled and not sent"
        yield function.declared.finding(Code.NRP355, target, message, Level.WARNING)
    for last, name in _filled_last(function.declared.node):
        message = f"'{name}' is filled and not returned here, so that this call publishes nothing"
        yield function.declared.finding(Code.NRP355, last, message, Level.WARNING)


def _filled_last(function: Function) -> Iterator[tuple[ast.stmt, str]]:
    """Yield where a function ends by filling a message that it returns elsewhere, and the message's name."""
    nodes = list(own_nodes(function.body))
    returned = {
        one.value.id for one in nodes if isinstance(one, ast.Return) and isinstance(one.value, ast.Name)
    }
    given = {
        one.id
        for call in nodes
        if isinstance(call, ast.Call)
        for one in call.args
        if isinstance(one, ast.Name)
    }
    blocks = [function.body]
    while blocks:
        *before, end = blocks.pop()
        if any(isinstance(one, ast.Return) for one in before):  # the end is never reached
            continue
        match end:
            case ast.If(_, body, orelse):
                blocks += [body, *([orelse] if orelse else [])]
            case ast.Assign([ast.Attribute() as target]) as last:
                name = ast.unparse(target).partition(".")[0]
                if name in returned - given - {one.arg for one in function.args.args}:
                    yield last, name


def _is_message(callee: object) -> bool:
    return isinstance(callee, type) and hasattr(callee, "__msgtype__")


def _filled(function: Function, messages: set[int]) -> Iterator[ast.Name]:
    """Yield the local names of messages of which only fields are set."""
    nodes = list(own_nodes(function.body))
    elsewhere = {one.arg for one in ast.walk(function.args) if isinstance(one, ast.arg)}
    for node in nodes:
        if isinstance(node, SCOPES):
            elsewhere |= {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        if isinstance(node, (ast.Global, ast.Nonlocal)):
            elsewhere.update(node.names)
    set_in = {id(root_of(one)) for one in nodes if isinstance(one, _PARTS) and isinstance(one.ctx, ast.Store)}
    for node in sorted((one for one in nodes if isinstance(one, ast.Assign)), key=lambda one: one.lineno):
        match node:
            case ast.Assign([ast.Name(name) as target], value) if id(value) in messages:
                uses = [one for one in nodes if isinstance(one, ast.Name) and one.id == name]
                others = [one for one in uses if one is not target]
                if name not in elsewhere and others and all(id(one) in set_in for one in others):
                    yield target
