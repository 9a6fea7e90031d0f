"""States of functions, kept as texts in variables, that a function asks for and nothing sets."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.shapes import Known, Shape
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions.mappings import MapVariable
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP248)
def states_are_set_somewhere(static: StaticExperiment) -> Iterator[Finding]:
    """Look for comparisons of a variable with a text that is neither its first value nor set anywhere."""
    if not static.is_complete:
        return
    uses: dict[str, list[tuple[CheckedFunction, str]]] = {}
    for function in static.functions:
        for name, mapping in function.function.mappings.items():
            if isinstance(mapping, MapVariable):
                key = mapping.global_key or f"{function.function.name}.{name}"
                uses.setdefault(key, []).append((function, name))
    for users in uses.values():
        values = [_values(function, name) for function, name in users]
        known = {value for some in values if some is not None for value in some}
        if known and None not in values:
            for function, name in users:
                yield from _asked_in_vain(function, name, known)


def _values(function: CheckedFunction, name: str) -> set[str] | None:
    """Return the texts that a function gives to a variable, the first one included; None if not all are."""
    mapping = function.function.mappings[name]
    assert isinstance(mapping, MapVariable)
    found = set[str]()
    if isinstance(mapping.initial_value, str):
        found.add(mapping.initial_value)
    elif mapping.initial_value is not None:
        return None
    nodes = function.declared.own
    inner = [one for one in ast.walk(function.declared.node) if _is_value(one, name)]
    names = [one for one in ast.walk(function.declared.node) if isinstance(one, ast.Name) and one.id == name]
    stores = [one for one in inner if isinstance(one, ast.Attribute) and isinstance(one.ctx, ast.Store)]
    set_to = [
        one.value
        for one in nodes
        if isinstance(one, ast.Assign)
        for target in one.targets
        if target in stores
    ]
    if len(names) != len(inner) or len(set_to) != len(stores):
        return None  # it is passed on, or set in another way
    for node in set_to:
        texts = _texts(node, function.declared.names)
        if texts is None:
            return None
        found |= texts
    return found


def _asked_in_vain(function: CheckedFunction, name: str, known: set[str]) -> Iterator[Finding]:
    for node in ast.walk(function.declared.node):
        match node:
            case ast.Compare(left, [ast.Eq() | ast.NotEq() as op], [right]) | ast.Compare(
                left, [ast.In() | ast.NotIn() as op], [ast.Tuple() | ast.List() | ast.Set() as right]
            ) if _is_value(left, name):
                texts = _texts(right, function.declared.names)
                if texts and texts.isdisjoint(known):
                    always = "always" if isinstance(op, ast.NotEq | ast.NotIn) else "never"
                    message = (
                        f"'{excerpt(node)}' is {always} true: '{name}.value' is only "
                        f"{' or '.join(map(repr, sorted(known)))}{did_you_mean(min(texts), known)}"
                    )
                    yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


def _texts(node: ast.expr, names: Mapping[str, Shape]) -> set[str] | None:
    """Return the texts that an expression may have, or the items of a tuple of texts; None for others."""
    match node:
        case ast.Constant(str() as text):
            return {text}
        case ast.Name(name) if isinstance(shape := names.get(name), Known) and isinstance(shape.value, str):
            return {shape.value}
        case ast.IfExp(_, body, orelse):
            parts = [body, orelse]
        case ast.Tuple(parts) | ast.List(parts) | ast.Set(parts):
            pass
        case _:
            return None
    texts = [_texts(one, names) for one in parts]
    return None if None in texts else {text for some in texts if some is not None for text in some}


def _is_value(node: ast.AST, name: str) -> bool:
    match node:
        case ast.Attribute(ast.Name(owner), "value"):
            return owner == name
    return False
