"""Constants of a file that are given again before anything reads them."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.declared import found_in
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.findings import Code, Finding, Level

_COMPUTED = (ast.Call, ast.Await, ast.NamedExpr, ast.Lambda)
"""Values that may do something when they are computed."""


@checks_experiment(Code.NRP300)
def constants_are_given_once(static: StaticExperiment) -> Iterator[Finding]:
    """Look for constants of a file that a later line gives again, with nothing between that reads them."""
    for source in static.sources:
        given: dict[str, int] = {}
        for statement in source.tree.body:
            name = _constant(statement)
            if _calls(statement):
                given.clear()
            for read in _names(statement, name):
                given.pop(read, None)
            if name and name in given:
                message = f"'{name}' is given again, so that its value in line {given[name]} is never used"
                yield found_in(source, Code.NRP300, statement, message, Level.WARNING)
            if name:
                given[name] = statement.lineno


def _constant(statement: ast.stmt) -> str:
    """Return the name that a statement gives a plain value other than None; empty if it does not."""
    match statement:
        case ast.Assign([ast.Name(name)], value) if not (
            any(isinstance(one, _COMPUTED) for one in ast.walk(value))
            or (isinstance(value, ast.Constant) and value.value is None)
        ):
            return name
    return ""


def _calls(statement: ast.stmt) -> bool:
    """Return whether a statement calls something, such as a function that reads the names of the file."""
    is_definition = isinstance(statement, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))
    return not is_definition and any(isinstance(one, _COMPUTED) for one in ast.walk(statement))


def _names(statement: ast.stmt, given: str) -> Iterator[str]:
    """Yield the names that a statement may read, or change in another way than by giving one its value."""
    for node in ast.walk(statement):
        if isinstance(node, ast.Name) and not (isinstance(node.ctx, ast.Store) and node.id == given):
            yield node.id
