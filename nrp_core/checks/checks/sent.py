"""Messages that are changed after they were sent."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.events import Call
from nrp_core.checks.registry import checks_function
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import Instance, Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.parameters.topics import PublishedTopic
from nrp_core.findings import Code, Finding, Level

_AGAIN = (ast.For, ast.AsyncFor, ast.While, ast.FunctionDef, ast.Lambda, ast.Global, ast.Nonlocal)
"""Code by which a later change may be sent all the same."""


@checks_function(Code.NRP355)
def messages_are_sent_when_they_are_whole(function: CheckedFunction) -> Iterator[Finding]:
    """Look for fields that are set after the message was sent, and of a message that is not used again."""
    body = function.declared.node.body
    nodes = list(own_nodes(body))
    if any(isinstance(node, _AGAIN) for statement in body for node in ast.walk(statement)):
        return
    sent = {id(event.node) for event in function.events if _is_sending(event)}
    for place, statement in enumerate(body):
        match statement:
            case ast.Expr(ast.Call(_, [ast.Name(name)], []) as call) if id(call) in sent:
                changed = [
                    found for later in body[place + 1 :] if (found := _set_in(later, name)) is not None
                ]
                used = sum(isinstance(one, ast.Name) and one.id == name for one in own_nodes(body[place:]))
                if changed and used == 1 + len(changed) and _is_own(name, nodes):
                    message = (
                        f"'{ast.unparse(changed[0])}' is set after line {call.lineno} has sent '{name}': the "
                        "change is not sent"
                    )
                    yield function.declared.finding(Code.NRP355, changed[0], message, Level.WARNING)


def _is_sending(event: object) -> bool:
    match event:
        case Call(_, Known(method), (Instance(),)):
            owner = getattr(method, "__self__", None)
            return isinstance(owner, PublishedTopic) and getattr(method, "__name__", "") == "send_message"
    return False


def _set_in(statement: ast.stmt, name: str) -> ast.Attribute | None:
    """Return the field of a message that a statement sets."""
    match statement:
        case ast.Assign([ast.Attribute() as target]) | ast.AugAssign(ast.Attribute() as target):
            root: ast.expr = target
            while isinstance(root, ast.Attribute):
                root = root.value
            return target if isinstance(root, ast.Name) and root.id == name else None
    return None


def _is_own(name: str, nodes: list[ast.AST]) -> bool:
    """Return whether a name is given once, by a call, and its object is known by no other name."""
    given = [one for one in nodes if isinstance(one, ast.Name) and one.id == name]
    made = [one for one in nodes if isinstance(one, ast.Assign) and isinstance(one.value, ast.Call)]
    targets = [id(target) for one in made for target in one.targets if len(one.targets) == 1]
    inner = {id(one.value) for one in nodes if isinstance(one, ast.Attribute)}
    stores = [one for one in given if isinstance(one.ctx, ast.Store)]
    whole = [one for one in given if isinstance(one.ctx, ast.Load) and id(one) not in inner]
    return len(stores) == 1 and id(stores[0]) in targets and len(whole) == 1
