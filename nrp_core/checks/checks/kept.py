"""Variables whose values do not live from call to call."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.dsl.functions.mappings import MapVariable
from nrp_core.findings import Code, Finding, Level


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
