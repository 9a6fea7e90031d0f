"""Names that nothing defines, as pyflakes finds them, and names of functions that are used twice."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from pyflakes import messages
from pyflakes.checker import Checker

from nrp_core.checks.check import checks_experiment
from nrp_core.checks.code.declarations import Declared, found_in
from nrp_core.checks.code.syntax import own_nodes
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.dsl.functions import name_taken_message
from nrp_core.dsl.loading import PythonSource
from nrp_core.errors import Instead, did_you_mean
from nrp_core.findings import Code, Finding, Level


@checks_experiment
def check_names(static: StaticExperiment) -> Iterator[Finding]:
    """Look for names that nothing defines."""
    for listing in static.listings:
        yield from _undefined(listing.sources, set(listing.names))
    for source in static.neighbours:
        yield from _undefined([source], set())


def _undefined(sources: Iterable[PythonSource], known: set[str]) -> Iterator[Finding]:
    for source in sources:
        checker = Checker(source.tree, str(source.path), builtins=known)
        open_lines = set(_lines_with_unknown_names(source.tree))
        for found in checker.messages:
            place = ast.Constant(None, lineno=found.lineno, col_offset=found.col)
            if isinstance(found, messages.UndefinedLocal):
                message = f"'{found.message_args[0]}' is used before it has a value"
                yield found_in(source, Code.NRP246, place, message)
            elif isinstance(found, messages.UndefinedName) and found.lineno not in open_lines:
                message, instead = _undefined_name(found, source.tree, known)
                yield found_in(source, Code.NRP246, place, message, Level.ERROR, instead)
        known |= set(checker.scopeStack[0] if checker.scopeStack else checker.deadScopes[-1])


def _lines_with_unknown_names(tree: ast.Module) -> Iterator[int]:
    """Yield the lines of scopes whose names cannot be known, because they execute a text."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    scopes: list[ast.Module | ast.FunctionDef] = [tree, *functions]
    for scope in scopes:
        if any(isinstance(one, ast.Name) and one.id == "exec" for one in own_nodes(scope.body)):
            last = max((getattr(one, "end_lineno", None) or 0 for one in ast.walk(scope)), default=0)
            yield from range(getattr(scope, "lineno", 1), last + 1)


def _undefined_name(found: messages.Message, tree: ast.Module, known: set[str]) -> tuple[str, Instead | None]:
    """Return the message about a name that nothing defines, and the name to replace it with."""
    name = str(found.message_args[0])
    function = next(
        (
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef) and node.lineno <= found.lineno <= (node.end_lineno or 0)
        ),
        None,
    )
    near = {one.arg for one in ast.walk(function) if isinstance(one, ast.arg)} if function else set()
    near |= {one.id for one in ast.walk(tree) if isinstance(one, ast.Name)} - {name}
    hint = did_you_mean(name, near | known)
    return f"nothing defines the name '{name}'{hint if hint.instead else ''}", hint.instead


@checks_experiment
def check_function_names(static: StaticExperiment) -> Iterator[Finding]:
    """Look for two functions with the same name."""
    first: dict[str, Declared] = {}
    for declared in static.declared:
        name = declared.function.name
        if not (declared.is_read and declared.is_named):  # a decorator in the user's file may have renamed it
            continue
        if name in first:
            other = first[name]
            message = name_taken_message(name, f"{other.source.path}:{other.node.lineno}")
            yield declared.finding(Code.NRP235, declared.node, message)
        first.setdefault(name, declared)
