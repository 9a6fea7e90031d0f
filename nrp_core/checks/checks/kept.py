"""Variables whose values do not live from call to call."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions.mappings import MapVariable
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP330)
def values_are_kept(function: CheckedFunction) -> Iterator[Finding]:
    """Look for variables that are reset before they are added to, and for copies that are changed."""
    body = function.declared.node.body
    for name, mapping in function.function.mappings.items():
        if not isinstance(mapping, MapVariable) or mapping.global_key is not None:
            continue
        first = next((one for one in body if _uses(one, name)), None)
        match first:
            case ast.Assign([target], ast.Constant()) if _is_value(target, name):
                after = body[body.index(first) + 1 :]
                if any(_adds_to(node, name) for one in after for node in ast.walk(one)):
                    message = (
                        f"'{excerpt(first)}' resets the variable in every call, before it is added "
                        "to: nothing of the last call is left"
                    )
                    yield function.declared.finding(Code.NRP330, first, message, Level.WARNING)
            case ast.Assign([ast.Name(copy)], value) if _is_value(value, name):
                changed = next((one for one in _nodes(body) if _changes(one, copy)), None)
                uses = [one for one in _nodes(body) if isinstance(one, ast.Name) and one.id == name]
                if changed is not None and len(uses) == 1:
                    message = f"this changes the copy '{copy}', and '{name}.value' stays as it was"
                    yield function.declared.finding(Code.NRP330, changed, message, Level.WARNING)


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


def _uses(node: ast.AST, name: str) -> bool:
    return any(isinstance(one, ast.Name) and one.id == name for one in ast.walk(node))


def _is_value(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Attribute) and ast.unparse(node) == f"{name}.value"


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load)


def _adds_to(node: ast.AST, name: str) -> bool:
    match node:
        case ast.AugAssign(target):
            return _is_value(target, name)
        case ast.Assign([target], ast.BinOp(left, _, right)):
            return _is_value(target, name) and (_is_value(left, name) or _is_value(right, name))
    return False


def _changes(node: ast.AST, name: str) -> bool:
    """Return whether a statement counts a name on."""
    match node:
        case ast.AugAssign(ast.Name(id), _, _):
            return id == name
        case ast.Assign([ast.Name(id)], ast.BinOp(ast.Name(left), ast.Add() | ast.Sub(), _)):
            return id == left == name
    return False
