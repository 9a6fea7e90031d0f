"""Items of devices, groups, numbers, messages and rows of files, and their number."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, TypeGuard

from nrp_core.checks.events import Call, Index, Read, Rename, Write
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Known, Number, Row, Shape, can_set, names_of
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.csv_recorder import CSVRecorder
from nrp_core.dsl.functions.mappings import MapCSVRecorder
from nrp_core.dsl.functions.variables import Variable
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name

_TIME_HEADERS = frozenset({"t", "time", "time_s", "t_s"})
_OF_MANY: tuple[Any, ...] = (min, max, sum)


@checks_function(Code.NRP252)
def indexed_values_have_items(function: CheckedFunction) -> Iterator[Finding]:
    """Look for items of values without items, and for indices out of range."""
    for event in function.events:
        match event:
            case Index(node, Known(DeviceGroup() as group), Known(int() as index)):
                if -len(group) <= index < len(group):
                    continue
                group_text = ast.unparse(node.value if isinstance(node, ast.Subscript) else node)
                message = (
                    f"'{group_text}' has {len(group)} devices, 0..{len(group) - 1}; {index} is out of range"
                )
            case Call(node, Known(callee), (owner,), _, True) if any(callee is one for one in _OF_MANY):
                what = _without_items(function, owner)
                if not what:
                    continue
                message = f"{callee.__name__} of one argument needs items, and {what} has none"
            case Index(node, owner, _):
                what = _without_items(function, owner)
                if not what:
                    continue
                message = f"{what} has no items"
            case _:
                continue
        yield function.declared.finding(Code.NRP252, event.node, message)


def _without_items(function: CheckedFunction, shape: Shape) -> str:
    """Return the kind of a value without items; empty if it may have items."""
    match shape:
        case Number() | Known(bool() | int() | float()):
            return "a number"
        case Instance(cls) if not any(
            hasattr(cls, name) for name in ("__getitem__", "__iter__", "__getattr__")
        ):
            return f"a {type_name(cls) if hasattr(cls, '__msgtype__') else cls.__name__}"
        case Known(Adapter() as adapter) if not hasattr(type(adapter), "__getitem__"):
            return f"'{function.parameter_of(shape) or type(adapter).__name__}'"
    return ""


@checks_function(Code.NRP225)
def groups_get_a_value_for_each(function: CheckedFunction) -> Iterator[Finding]:
    """Look for lists that have more or fewer values than a group has devices."""
    for event in function.events:
        match event:
            case Write(node, Known(DeviceGroup() as group), name, True, Row(items)):
                is_known = all(isinstance(item, Known) for item in items)  # another check tries it
                if len(items) != len(group) and can_set(group, name) and not is_known:
                    message = f"{len(items)} values for '{name}' of {len(group)} devices"
                    yield function.declared.finding(Code.NRP225, node, message)


@checks_function(Code.NRP253)
def parameters_stay_what_they_are(function: CheckedFunction) -> Iterator[Finding]:
    """Look for parameters that are overwritten, where an attribute was probably intended."""
    lost: dict[str, Shape] = {}
    for event in function.events:
        match event:
            case Rename(ast.Name(name), Known(Adapter()) as owner):
                lost[name] = owner
            case Read(ast.Attribute(ast.Name(name)) as node, owner) | Write(
                ast.Attribute(ast.Name(name)) as node, owner
            ) if name in lost and event.name in names_of(lost[name]):
                if isinstance(owner, (Known, Instance)):
                    continue
                message = (
                    f"'{name}' was overwritten above and is no longer its device or topic; "
                    f"did you mean '{name}.{node.attr} = ...' there?"
                )
                yield function.declared.finding(Code.NRP253, node, message, Level.WARNING)
                del lost[name]


@checks_function(Code.NRP253)
def variables_are_set_by_their_value(function: CheckedFunction) -> Iterator[Finding]:
    """Look for ``n = n.value + 1``, which leaves the variable as it is."""
    renamed = {
        id(event.node) for event in function.events if isinstance(event, Rename) and _is_variable(event)
    }
    nodes = list(ast.walk(function.declared.node))
    for node in nodes:
        match node:
            case ast.Assign([ast.Name(name) as target], value) if id(target) in renamed:
                own = {id(one) for one in ast.walk(value)}
                others = [one for one in nodes if id(one) not in own and _is_read(one, name)]
                is_set = any(_is_value_of(one, name) and isinstance(one.ctx, ast.Store) for one in nodes)
                if any(_is_value_of(one, name) for one in ast.walk(value)) and (
                    not others or (_counts_on(value, name) and not is_set)
                ):
                    message = f"this sets the name '{name}', not the variable: write '{name}.value = ...'"
                    yield function.declared.finding(Code.NRP253, node, message, Level.WARNING)


@checks_function(Code.NRP253)
def loops_leave_parameters_alone(function: CheckedFunction) -> Iterator[Finding]:
    """Look for loops over the name of a parameter that is used after them."""
    for node in function.declared.own:
        match node:
            case ast.For(ast.Name(name), _, body) if name in function.function.parameters or name == "t":
                end = body[-1].end_lineno or 0
                after = [one for one in function.declared.own if _is_read(one, name) and one.lineno > end]
                if after:
                    message = (
                        f"this loop overwrites '{name}', which is used again in line "
                        f"{min(one.lineno for one in after)}: use another name"
                    )
                    yield function.declared.finding(Code.NRP253, node, message, Level.WARNING)


def _is_variable(event: Rename) -> bool:
    return isinstance(event.owner, Known) and isinstance(event.owner.value, Variable)


def _is_read(node: ast.AST, name: str) -> TypeGuard[ast.Name]:
    return isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load)


def _is_value_of(node: ast.AST, name: str) -> TypeGuard[ast.Attribute]:
    return isinstance(node, ast.Attribute) and node.attr == "value" and _is_read(node.value, name)


def _counts_on(value: ast.expr, name: str) -> bool:
    """Return whether an expression adds to the value of a variable."""
    return (
        isinstance(value, ast.BinOp)
        and isinstance(value.op, (ast.Add, ast.Sub))
        and any(_is_value_of(side, name) for side in (value.left, value.right))
    )


@checks_function(Code.NRP254)
def headers_are_a_list(function: CheckedFunction) -> Iterator[Finding]:
    """Look for headers that are a single string, of which each letter would become a column."""
    for name, mapping in function.function.mappings.items():
        node = function.declared.nodes.get(name)
        if not isinstance(mapping, MapCSVRecorder) or not isinstance(node, ast.Call):
            continue
        written = [*node.args[2:3], *(one.value for one in node.keywords if one.arg == "headers")]
        if any(isinstance(one, ast.Constant) for one in written):
            message = f"headers are a list of texts, as ['t', 'x'], not {ast.unparse(written[0])}"
            yield function.declared.finding(Code.NRP254, node, message, Level.WARNING)
        elif len(set(mapping.headers)) < len(mapping.headers):
            twice = next(one for one in mapping.headers if mapping.headers.count(one) > 1)
            message = f"two columns have the header '{twice}'"
            yield function.declared.finding(Code.NRP254, node, message, Level.WARNING)


@checks_function(Code.NRP254)
def rows_fit_their_headers(function: CheckedFunction) -> Iterator[Finding]:
    """Compare the values that are recorded with the headers."""
    for event in function.events:
        if not (isinstance(event, Call) and event.is_whole and isinstance(event.callee, Known)):
            continue
        recorder = getattr(event.callee.value, "__self__", None)
        if not isinstance(recorder, CSVRecorder) or event.callee.value.__name__ != "record_entry":
            continue
        headers, values = recorder.headers, event.given
        if len(values) != len(headers):
            message = f"a row of {len(values)} under {len(headers)} headers: {', '.join(headers)}"
            yield function.declared.finding(Code.NRP254, event.node, message, Level.WARNING)
            continue
        timed = [i for i, one in enumerate(headers) if one.lower() in _TIME_HEADERS]
        given = [i for i, one in enumerate(event.node.args) if isinstance(one, ast.Name) and one.id == "t"]
        if len(timed) == len(given) == 1 and timed != given:
            message = f"the time 't' goes below '{headers[given[0]]}', and not below '{headers[timed[0]]}'"
            yield function.declared.finding(Code.NRP254, event.node, message, Level.WARNING)
