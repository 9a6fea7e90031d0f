"""Sharing and initial values of variables."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator

from nrp_core.checks.events import Compute, Read, Write
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions.mappings import MapVariable
from nrp_core.findings import Code, Finding, Level

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
