"""Parameters, variables, sources and topics of functions that contradict each other or that nothing sets."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core.checks.check import checks_experiment, checks_function
from nrp_core.checks.code.syntax import root_of
from nrp_core.checks.code.values import Known, names_of
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapSpikeSource, MapVariable, Variable
from nrp_core.dsl.parameters import Adapter
from nrp_core.findings import Code, Finding, Level

_WIRING: Final = {"connector", "weight", "delay", "receptor_type", "synapse_type"}
"""Settings of a source that make no spikes."""


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
            yield function.declared.finding(Code.NRP231, node, message, Level.WARNING)


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
                yield examined.declared.finding(Code.NRP229, node, message, Level.WARNING)


# -- parameters and variables


@checks_function
def check_rebound_parameters(function: CheckedFunction) -> Iterator[Finding]:
    """Look for parameters to which a body assigns a value, where an attribute was probably intended."""
    own = function.declared.own
    reads = [one for one in own if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load)]
    for node in own:
        match node:
            case ast.Assign([ast.Name(name) as target], value) if name in function.adapters:
                adapter, after = function.adapters[name], node.end_lineno or 0
                inner = {id(one) for one in ast.walk(value)}
                later = [one for one in reads if one.id == name and one.lineno > after]
                is_read_in_it = any(isinstance(one, ast.Name) and one.id == name for one in ast.walk(value))
                others = [one for one in reads if one.id == name and id(one) not in inner]
                is_sum = _sums(value, name) and not _uses_of_value(function, name)[1]
                if isinstance(adapter, Variable) and is_read_in_it and (not others or is_sum):
                    message = f"this sets the name '{name}', not the variable: write '{name}.value = ...'"
                    yield function.declared.finding(Code.NRP253, target, message, Level.WARNING)
                elif not _is_part_of(value, name) and (used := _used_attribute(own, later, adapter)):
                    message = (
                        f"'{name}' was overwritten above and is no longer its device or topic; "
                        f"did you mean '{name}.{used.attr} = ...' there?"
                    )
                    yield function.declared.finding(Code.NRP253, used, message, Level.WARNING)


def _is_part_of(value: ast.expr, name: str) -> bool:
    """Return whether an expression is a name or an attribute of one: ``camera.value``."""
    root = root_of(value)
    return isinstance(root, ast.Name) and root.id == name


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
        yield function.declared.finding(
            Code.NRP330, function.declared.nodes.get(name), message, Level.WARNING
        )


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
