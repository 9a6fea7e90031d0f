"""Undefined names, unused values and conditions that do not test, as pyflakes finds them in a file."""

from __future__ import annotations

import ast
from collections.abc import Container, Iterable, Iterator

from pyflakes import messages
from pyflakes.checker import Checker

from nrp_core.checks.declared import found_in
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment, at_most
from nrp_core.dsl.loading.listing import PythonSource
from nrp_core.errors import Instead, did_you_mean
from nrp_core.findings import Code, Finding, Level

_CODES = {
    messages.UndefinedName: (Code.NRP246, Level.ERROR),
    messages.UndefinedLocal: (Code.NRP246, Level.ERROR),
    messages.UnusedVariable: (Code.NRP242, Level.WARNING),
    messages.IsLiteral: (Code.NRP300, Level.WARNING),
    messages.AssertTuple: (Code.NRP300, Level.WARNING),
    messages.IfTuple: (Code.NRP300, Level.WARNING),
    messages.RedefinedWhileUnused: (Code.NRP300, Level.WARNING),
    messages.MultiValueRepeatedKeyLiteral: (Code.NRP300, Level.WARNING),
}
_OF_SCRIPTS = frozenset({
    messages.UndefinedName, messages.UndefinedLocal, messages.IsLiteral, messages.AssertTuple,
    messages.IfTuple, messages.RedefinedWhileUnused, messages.MultiValueRepeatedKeyLiteral,
})  # fmt: skip
"""Messages about brain scripts, in which a synapse is often kept under a name that nothing reads."""
_PLAIN = {
    messages.IsLiteral: "'is' compares whether two objects are the same, not their values: write '=='",
    messages.AssertTuple: "this assertion is always true: a tuple with items is; remove the parentheses",
    messages.IfTuple: "this condition is always true: a tuple with items is; remove the comma",
}
"""Messages without a name in them."""


@checks_experiment(Code.NRP246, Code.NRP242, Code.NRP300)
def names_are_defined_and_used(static: StaticExperiment) -> Iterator[Finding]:
    """Look for undefined names, unused local values, and conditions that are always true."""
    for listing in static.listings:
        yield from _names_of(listing.sources, set(listing.names))
    for source in static.neighbours:
        yield from _names_of([source], set())
    for source in static.scripts:  # it was executed, so an undefined name is one that it did not reach
        yield from (at_most(one, Level.WARNING) for one in _names_of([source], set(), _OF_SCRIPTS))


def _names_of(
    sources: Iterable[PythonSource], known: set[str], kinds: Container[type] = _CODES
) -> Iterator[Finding]:
    for source in sources:
        checker = Checker(source.tree, str(source.path), builtins=known)
        for found in checker.messages:
            code, level = _CODES.get(type(found), (None, Level.NOTE))
            if code is not None and type(found) in kinds and not _is_meant(found, source.tree):
                message, instead = _message(found, source.tree, known)
                yield found_in(source, code, _at(found), message, level, instead)
        known |= set(checker.scopeStack[0] if checker.scopeStack else checker.deadScopes[-1])


def _is_meant(found: messages.Message, tree: ast.Module) -> bool:
    """Return whether a name is given again by an import, or by a decorator that keeps what it decorates."""
    return isinstance(found, messages.RedefinedWhileUnused) and not any(
        isinstance(node, ast.FunctionDef | ast.ClassDef)
        and (node.lineno, node.name) == (found.lineno, found.message_args[0])
        and not node.decorator_list
        for node in ast.walk(tree)
    )


def _at(found: messages.Message) -> ast.AST:
    return ast.Constant(None, lineno=found.lineno, col_offset=found.col)


def unused_value(name: str) -> str:
    """Return the message about a local name whose value is never used."""
    return f"the value of '{name}' is never used"


def replaced_parameter(name: str) -> str:
    """Return the message about a value that replaces a parameter, and is never used."""
    return f"this replaces the parameter and sets nothing: {unused_value(name)}"


def _message(found: messages.Message, tree: ast.Module, known: set[str]) -> tuple[str, Instead | None]:
    """Return a message, and the name to replace one with that nothing defines."""
    if type(found) in _PLAIN:
        return _PLAIN[type(found)], None
    name = str(found.message_args[0])
    if isinstance(found, messages.RedefinedWhileUnused):
        return (
            f"'{name}' is defined again, so that the definition in line {found.message_args[1]} is lost",
            None,
        )
    if isinstance(found, messages.MultiValueRepeatedKeyLiteral):
        return (
            f"the key {found.message_args[0]!r} of this dictionary has several values; the last one counts",
            None,
        )
    if isinstance(found, messages.UndefinedLocal):
        return f"'{name}' is used before it has a value", None
    near = next(
        (
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef) and node.lineno <= found.lineno <= (node.end_lineno or 0)
        ),
        None,
    )
    local = {one.arg for one in ast.walk(near) if isinstance(one, ast.arg)} if near else set()
    if isinstance(found, messages.UnusedVariable):
        return (replaced_parameter if name in local else unused_value)(name), None
    local |= {one.id for one in ast.walk(tree) if isinstance(one, ast.Name)} - {name}
    hint = did_you_mean(name, local | known)
    return f"nothing defines the name '{name}'{hint if hint.instead else ''}", hint.instead
