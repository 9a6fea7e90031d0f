"""Names that nothing defines, and wiring that nothing sets or that contradicts itself."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from typing import Final

from pyflakes import messages
from pyflakes.checker import Checker

from nrp_core.checks.code.declarations import Declared, found_in
from nrp_core.checks.code.syntax import names_in, own_nodes, root_name
from nrp_core.checks.code.values import Known, names_of
from nrp_core.checks.static_experiment import (
    CheckedFunction,
    StaticExperiment,
    checks_experiment,
    checks_function,
)
from nrp_core.dsl.functions import TransferFunction, name_taken_message
from nrp_core.dsl.loading import PythonSource
from nrp_core.dsl.mappings import MapSpikeSource, MapVariable, Variable
from nrp_core.dsl.parameters import Adapter
from nrp_core.errors import Instead, did_you_mean
from nrp_core.findings import Code, Finding, Level

_WIRING: Final = {"connector", "weight", "delay", "receptor_type", "synapse_type"}
"""Settings of a source that make no spikes."""


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
    near = {
        one.arg
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.lineno <= found.lineno <= (node.end_lineno or 0)
        for one in ast.walk(node)
        if isinstance(one, ast.arg)
    }
    hint = did_you_mean(name, (near | names_in(tree) | known) - {name})
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


# -- sources


@checks_function
def check_sources(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sources that a body never sets, and for those whose spikes have no effect."""
    only_read = _only_read(function)
    for name, mapping in function.function.mappings.items():
        if not isinstance(mapping, MapSpikeSource):
            continue
        message, weight = "", mapping.options.get("weight")
        if (
            name in only_read
            and name not in function.function.triggers
            and not set(mapping.options) - _WIRING
        ):
            message = f"nothing sets the source '{name}': it stays silent"
        elif isinstance(weight, int | float) and weight == 0:
            message = f"the weight of the source '{name}' is 0: its spikes have no effect"
        if message:
            node = function.declared.parameter(name)
            yield function.warning(Code.NRP231, node, message)


def _only_read(function: CheckedFunction) -> set[str]:
    """Return the parameters whose attributes the body at most reads; a method call may set them."""
    body = ast.Module(function.declared.node.body, [])
    parents = {id(child): node for node in ast.walk(body) for child in ast.iter_child_nodes(node)}
    others: set[str] = set()
    for node in ast.walk(body):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Store):
            parent = parents.get(id(node))
            reads = isinstance(parent, ast.Attribute) and isinstance(parent.ctx, ast.Load)
            if not reads or isinstance(parents.get(id(parent)), ast.Call | ast.Subscript):
                others.add(node.id)
    return set(function.function.parameters) - others


@checks_experiment
def check_publishers(static: StaticExperiment) -> Iterator[Finding]:
    """Look for topics that two functions publish on, or one function twice."""
    first: dict[str, tuple[TransferFunction, str]] = {}
    for examined in static.functions:
        function = examined.function
        written = {(topic.name, "") for topic in [function.topic] if topic is not None}
        written |= {
            (mapping.writes.name, name) for name, mapping in function.mappings.items() if mapping.writes
        }
        for topic, parameter in sorted(written) if function.active else ():
            other, _ = found = first.setdefault(topic, (function, parameter))
            if found != (function, parameter):
                twice = f"'{function.name}' publishes on '{topic}' twice"
                also = f"'{function.name}' publishes on '{topic}', as '{other.name}' does"
                message = twice if other is function else also
                node = examined.declared.nodes.get(parameter)
                yield examined.warning(Code.NRP229, node, message)


# -- parameters and variables


@checks_function
def check_rebound_parameters(function: CheckedFunction) -> Iterator[Finding]:
    """Look for parameters to which a body assigns a value, where an attribute was probably intended."""
    own = function.declared.own
    loads = [one for one in own if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load)]
    for node in own:
        match node:
            case ast.Assign([ast.Name(name) as target], value) if name in function.adapters:
                adapter, inner = function.adapters[name], set(ast.walk(value))
                reads = [one for one in loads if one.id == name]
                others = [one for one in reads if one not in inner]
                is_sum = _sums(value, name) and not _uses_of_value(function, name)[1]
                if isinstance(adapter, Variable) and len(others) < len(reads) and (not others or is_sum):
                    message = f"this sets the name '{name}', not the variable: write '{name}.value = ...'"
                    yield function.warning(Code.NRP253, target, message)
                    continue
                later = [one for one in reads if one.lineno > (node.end_lineno or 0)]
                used = _used_attribute(own, later, adapter)
                if used is not None and root_name(value) != name:  # not ``camera = camera.value``
                    message = (
                        f"'{name}' was overwritten above and is no longer its device or topic; "
                        f"did you mean '{name}.{used.attr} = ...' there?"
                    )
                    yield function.warning(Code.NRP253, used, message)


def _sums(value: ast.expr, name: str) -> bool:
    """Return whether an expression adds to the value of a variable."""
    return (
        isinstance(value, ast.BinOp)
        and isinstance(value.op, ast.Add | ast.Sub)
        and any(ast.unparse(side) == f"{name}.value" for side in (value.left, value.right))
    )


def _used_attribute(
    nodes: tuple[ast.AST, ...], reads: list[ast.Name], adapter: Adapter
) -> ast.Attribute | None:
    """Return an attribute of an adapter that is used by a name after another value was assigned to it."""
    names, places = names_of(Known(adapter)), {id(one) for one in reads}
    found = (one for one in reversed(nodes) if isinstance(one, ast.Attribute) and id(one.value) in places)
    return next((one for one in found if one.attr in names), None)


@checks_experiment
def check_shared_variables(static: StaticExperiment) -> Iterator[Finding]:
    """Look for a variable that one function only reads and another only sets under the same name."""
    uses = [
        (function, name, mapping.global_key, *_uses_of_value(function, name))
        for function in static.functions
        for name, mapping in function.function.mappings.items()
        if isinstance(mapping, MapVariable)
    ]
    shared_set = {key for *_, key, _, is_set in uses if is_set}
    shared_read = {key for *_, key, is_read, _ in uses if is_read}
    local_setters = {name: one.function.name for one, name, key, is_read, is_set in uses
                     if key is None and is_set and not is_read}  # fmt: skip
    for function, name, key, is_read, is_set in uses:
        if key is not None or not is_read or is_set:
            continue
        if name in shared_set - shared_read:
            message = f"nothing sets this '{name}': another function sets the one with scope=nrp.GLOBAL"
        elif name in local_setters:
            message = (
                f"nothing sets this '{name}': '{local_setters[name]}' sets another of its own; "
                "scope=nrp.GLOBAL in both makes it one"
            )
        else:
            continue
        yield function.warning(Code.NRP330, function.declared.nodes.get(name), message)


def _uses_of_value(function: CheckedFunction, name: str) -> tuple[bool, bool]:
    """Return whether a body reads, and whether it sets, the value of a variable."""
    reads = sets = False
    for node in ast.walk(ast.Module(function.declared.node.body, [])):
        match node:
            case ast.AugAssign(ast.Attribute(ast.Name(owner), "value")) if owner == name:
                reads = True
            case ast.Attribute(ast.Name(owner), "value", context) if owner == name:
                reads |= isinstance(context, ast.Load)
                sets |= not isinstance(context, ast.Load)
    return reads, sets
