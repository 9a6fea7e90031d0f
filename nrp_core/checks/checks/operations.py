"""Operations on devices, topics, messages and values that fail: attributes, calls, items, computations."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from math import isnan
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any, TypeGuard

import numpy as np

from nrp_core.checks.code.shapes import (
    UNITS,
    Add,
    Call,
    Compute,
    Divide,
    Index,
    Instance,
    Items,
    Known,
    Multiply,
    Names,
    Number,
    Read,
    Rename,
    Return,
    Row,
    Shape,
    Write,
    can_set,
    full_names,
    missing_name,
    names_of,
)
from nrp_core.checks.code.statements import Written
from nrp_core.checks.registry import checks_function
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.devices import Device, DeviceGroup, attribute_hint
from nrp_core.dsl.mappings import CSVRecorder, MapCSVRecorder, MapSpikeSink, MapSpikeSource, Variable
from nrp_core.dsl.parameters import Adapter, PublishedTopic, SubscribedTopic
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name

_PLAIN = ("math", "builtins")
"""Modules whose functions have known signatures."""
_SEEDED = ("random.Random", "random.seed")
_CLOCKS = frozenset(
    {f"time.{name}" for name in ("time", "clock", "perf_counter", "monotonic", "process_time", "time_ns")}
    | {"datetime.datetime.now", "datetime.now", "datetime.datetime.today"}
)


@checks_function(Code.NRP240)
def calls_fit(function: CheckedFunction) -> Iterator[Finding]:
    """Compare the arguments of functions and methods with their signatures."""
    for event in function.events:
        match event:
            case Call(node, Known(callee), given, named, True) if _is_checked(callee):
                signature = inspect.signature(callee)
                try:
                    signature.bind(*given, **named)
                except TypeError as error:
                    plain = signature.replace(
                        parameters=[
                            one.replace(annotation=one.empty) for one in signature.parameters.values()
                        ],
                        return_annotation=signature.empty,
                    )
                    message = f"{callee.__name__}{plain}: {error}"
                    yield function.declared.finding(Code.NRP240, node, message)


def _is_checked(callee: Any) -> bool:
    """Return whether the arguments of calls of something are checked."""
    if isinstance(callee, Written):
        return True
    if isinstance(callee, (FunctionType, MethodType)):
        return str(callee.__module__).startswith("nrp_core.")
    return isinstance(callee, BuiltinFunctionType) and callee.__module__ in _PLAIN and _has_signature(callee)


def _has_signature(callee: Any) -> bool:
    try:
        return bool(inspect.signature(callee).parameters)
    except ValueError:
        return False


@checks_function(Code.NRP240)
def only_functions_are_called(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls of numbers, messages and devices."""
    for event in function.events:
        match event:
            case Call(node, Number() | Items() | Row()):
                pass
            case Call(node, Instance(cls)) if not any("__call__" in vars(kind) for kind in cls.__mro__):
                pass
            case Call(node, Known(value)) if not callable(value):
                pass
            case _:
                continue
        message = f"'{ast.unparse(node.func)}' is not a function and cannot be called"
        yield function.declared.finding(Code.NRP240, node, message)


@checks_function(Code.NRP243)
def nothing_depends_on_the_clock(function: CheckedFunction) -> Iterator[Finding]:
    """Look for the wall clock, and for functions that sleep."""
    imported = full_names(function.declared.source.tree)
    decisive = set(_deciding_calls(function.declared.node))
    for node in ast.walk(ast.Module(function.declared.node.body, [])):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        if not re.fullmatch(r"[\w.]+", name):
            continue  # of a result, such as a generator with its own seed
        root, _, rest = name.partition(".")
        called = ".".join(part for part in (imported.get(root, ""), rest) if part)
        if isinstance(function.declared.names.get(root), Known):
            continue  # this name is not a clock but a substitute of ours
        if called == "time.sleep":
            message = f"'{name}' stops the whole loop: simulated time stands still meanwhile"
            yield function.declared.finding(Code.NRP243, node, message, Level.WARNING)
        elif called in _CLOCKS or (called.startswith("random.") and called not in _SEEDED):
            message, level = f"'{name}' differs between runs", Level.NOTE
            if node in decisive:
                message, level = f"{message}, and what is returned depends on it", Level.WARNING
            yield function.declared.finding(Code.NRP243, node, message, level)


def _deciding_calls(node: ast.AST) -> Iterator[ast.Call]:
    """Yield the calls in conditions under which a function returns a value."""
    for one in ast.walk(node):
        if isinstance(one, ast.If) and any(
            isinstance(inner, ast.Return) and inner.value is not None for inner in ast.walk(one)
        ):
            yield from (call for call in ast.walk(one.test) if isinstance(call, ast.Call))


@checks_function(Code.NRP357)
def functions_do_not_wait(function: CheckedFunction) -> Iterator[Finding]:
    """Look for functions that sleep in simulated time, which passes between their calls only."""
    imported = full_names(function.declared.source.tree)
    for node in function.declared.own:
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        root, _, rest = name.partition(".")
        if f"{imported.get(root, root)}.{rest}".strip(".") == "rospy.sleep":
            message = f"'{name}' returns at once: simulated time stands still while a transfer function runs"
            yield function.declared.finding(Code.NRP357, node, message, Level.WARNING)


@checks_function(Code.NRP243)
def nothing_depends_on_chance(function: CheckedFunction) -> Iterator[Finding]:
    """Look for the global random generators."""
    for event in function.events:
        if isinstance(event, Call) and isinstance(event.callee, Known):
            callee = event.callee.value
            module = str(getattr(getattr(callee, "__self__", None), "__class__", type(None)).__module__)
            if module.startswith("numpy.random") and not isinstance(callee, type):
                message = f"'numpy.random.{callee.__name__}' draws from a generator that all share"
                yield function.declared.finding(Code.NRP243, event.node, message, Level.NOTE)


_OF_VALUES: tuple[Any, ...] = (min, max, abs, float, int, round, sum, len)
_TELLING = ("value", "voltage", "rate", "times", "amplitude", "mean")
"""The main attribute of a device, topic or variable."""
_FUNCTIONS = (FunctionType, MethodType, BuiltinFunctionType, Written, np.ufunc)
_ARITHMETIC = ("__add__", "__radd__", "__sub__", "__mul__", "__rmul__", "__truediv__", "__neg__", "__float__")


@checks_function(Code.NRP247)
def numbers_are_computed_with(function: CheckedFunction) -> Iterator[Finding]:
    """Look for values that are not numbers in computations and in arguments of numeric functions."""
    for event in function.events:
        match event:
            case Compute(node, Known(DeviceGroup())):
                wrong = f"'{ast.unparse(node)}' is a group of devices, not a value"
            case Compute(node, operand):
                wrong = _no_number(function, operand)
            case Add(ast.BinOp() as node, left, right) | Multiply(node, left, right):
                wrong = (
                    _text_and_number(node, left, right)
                    or _list_and_number(left, right)
                    or _never_a_number(left, right)
                )
            case Divide(node, left, right):
                is_text = isinstance(node.op, ast.Mod) and not isinstance(left, Number)
                wrong = _list_and_number(left, right) or ("" if is_text else _never_a_number(left, right))
            case Return(node, Known(Adapter()) as given) if function.returns_to is not None:
                wrong = _no_number(function, given)
            case Call(node, Known(callee), given, named):
                if not _takes_values(callee):
                    continue
                shapes = [one for one in (*given, *named.values()) if callee is not len or not _is_sized(one)]
                wrong = next(filter(None, (no_value(function, one) for one in shapes)), "")
            case _:
                continue
        if wrong:
            yield function.declared.finding(Code.NRP247, node, wrong)


@checks_function(Code.NRP240)
def settings_are_numbers(function: CheckedFunction) -> Iterator[Finding]:
    """Look for settings of devices that are assigned values that are not numbers, or are true or false."""
    compared = {
        id(target)
        for node in function.declared.own
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Compare)
        for target in node.targets
    }
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, value) if name in UNITS:
                shapes = value.items if isinstance(value, Row) else (value,)
                wrong = next(filter(None, (_no_number(function, shape) for shape in shapes)), "")
                if wrong:
                    message = f"'{name}' takes a number: {wrong}"
                    yield function.declared.finding(Code.NRP240, node, message)
                elif id(node) in compared or any(one == Instance(bool) or _is(one, bool) for one in shapes):
                    message = _truth_value(name, UNITS[name])
                    yield function.declared.finding(Code.NRP240, node, message, Level.WARNING)


def _takes_values(callee: Any) -> bool:
    """Return whether a function takes numbers or messages only, and not devices or topics."""
    if any(callee is one for one in _OF_VALUES):
        return True
    if not isinstance(callee, (FunctionType, MethodType)) and not type(callee).__module__.startswith("numpy"):
        return False
    module = str(getattr(callee, "__module__", ""))
    return module.startswith(
        ("nrp_core.dsl.tf_lib", "nrp_core.dsl.messages", "nrp_core.dsl.parameters", "numpy")
    )


def _truth_value(name: str, unit: str) -> str:
    return (
        f"'{name}' is in {unit} and is set to true or false, which is 1 or 0 {unit}; "
        f"write the value: 100.0 if ... else 0.0"
    )


def _text_and_number(node: ast.BinOp, left: Shape, right: Shape) -> str:
    """Return why two values cannot be combined; empty if they can or if they are unknown."""
    repeats = isinstance(node.op, ast.Mult) and (_is(left, int) or _is(right, int))
    if repeats or not _are_text_and_number(left, right):
        return ""
    return "a text and a number cannot be combined; write f'...{number}', or float(text)"


def _are_text_and_number(left: Shape, right: Shape) -> bool:
    return any(
        _is(one, str) and (isinstance(other, Number) or _is(other, (int, float)))
        for one, other in ((left, right), (right, left))
    )


def _list_and_number(left: Shape, right: Shape) -> str:
    """Return why the list of a group's values cannot be used in a computation; empty if unknown."""
    for one, other in ((left, right), (right, left)):
        reads_group = isinstance(one, Items) and isinstance(one.item, Number) and one.item.unit
        if reads_group and isinstance(other, Known) and type(other.value) is float:  # a NumPy function works
            return "a group returns a list with a number for each device: [2.0 * one for one in ...]"
    return ""


def _never_a_number(left: Shape, right: Shape) -> str:
    """Return why two values cannot be computed with: one is None, nan, or a function without its call."""
    for shape in (left, right):
        match shape:
            case Known(None):
                return "None is not a number"
            case Known(float() as value) if isnan(value):
                return "the result is always nan, which topics and devices refuse"
            case _:
                uncalled = not_called(shape)
                if uncalled:
                    return uncalled
    return ""


def not_called(shape: Shape) -> str:
    """Return that a value is a function or class, as one without its parentheses is; empty if not."""
    value: Any = shape.value if isinstance(shape, Known) else None
    kind = "class" if isinstance(value, type) else "function" if isinstance(value, _FUNCTIONS) else ""
    return f"'{value.__name__}' is a {kind}, not a value; call it: {value.__name__}(...)" if kind else ""


def _is(shape: Shape, kinds: type | tuple[type, ...]) -> bool:
    return isinstance(shape, Known) and isinstance(shape.value, kinds)


def _is_sized(shape: Shape) -> bool:
    return isinstance(shape, Known) and hasattr(type(shape.value), "__len__")


def _no_number(function: CheckedFunction, shape: Shape) -> str:
    """Return why a value cannot be used in a computation; empty if it can or if it is unknown."""
    match shape:
        case Instance(cls) if not any(hasattr(cls, name) for name in _ARITHMETIC):
            name = type_name(cls) if hasattr(cls, "__msgtype__") else cls.__name__
            fields = ", ".join(names_of(shape)[:4])
            return f"a {name} is not a number; its fields are {fields}"
    return no_value(function, shape)


def no_value(function: CheckedFunction, shape: Shape) -> str:
    """Return why a parameter is not a value; empty if it may be one."""
    match shape:
        case Known(DeviceGroup()):
            return ""
        case Known(Adapter() as adapter) if not any(hasattr(type(adapter), name) for name in _ARITHMETIC):
            name = function.parameter_of(shape) or "it"
            meant = next((one for one in _TELLING if one in names_of(shape)), "")
            hint = f"; did you mean '{name}.{meant}'?" if meant else ""
            return f"'{name}' is a {_kind(adapter)}, not a value{hint}"
    return ""


def _kind(adapter: Adapter) -> str:
    words = {
        "SubscribedTopic": "subscribed topic",
        "PublishedTopic": "published topic",
        "Variable": "variable",
    }
    return words.get(
        type(adapter).__name__, "device" if isinstance(adapter, Device) else type(adapter).__name__
    )


_TIME_HEADERS = frozenset({"t", "time", "time_s", "t_s"})
_OF_MANY: tuple[Any, ...] = (min, max, sum)


@checks_function(Code.NRP240)
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
        yield function.declared.finding(Code.NRP240, event.node, message)


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


@checks_function(Code.NRP240)
def groups_get_a_value_for_each(function: CheckedFunction) -> Iterator[Finding]:
    """Look for lists that have more or fewer values than a group has devices."""
    for event in function.events:
        match event:
            case Write(node, Known(DeviceGroup() as group), name, True, Row(items)):
                is_known = all(isinstance(item, Known) for item in items)  # another check tries it
                if len(items) != len(group) and can_set(group, name) and not is_known:
                    message = f"{len(items)} values for '{name}' of {len(group)} devices"
                    yield function.declared.finding(Code.NRP240, node, message)


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


@checks_function(Code.NRP240)
def headers_are_a_list(function: CheckedFunction) -> Iterator[Finding]:
    """Look for headers that are a single string, of which each letter would become a column."""
    for name, mapping in function.function.mappings.items():
        node = function.declared.nodes.get(name)
        if not isinstance(mapping, MapCSVRecorder) or not isinstance(node, ast.Call):
            continue
        written = [*node.args[2:3], *(one.value for one in node.keywords if one.arg == "headers")]
        if any(isinstance(one, ast.Constant) for one in written):
            message = f"headers are a list of texts, as ['t', 'x'], not {ast.unparse(written[0])}"
            yield function.declared.finding(Code.NRP240, node, message, Level.WARNING)
        elif len(set(mapping.headers)) < len(mapping.headers):
            twice = next(one for one in mapping.headers if mapping.headers.count(one) > 1)
            message = f"two columns have the header '{twice}'"
            yield function.declared.finding(Code.NRP240, node, message, Level.WARNING)


@checks_function(Code.NRP240)
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
            yield function.declared.finding(Code.NRP240, event.node, message, Level.WARNING)
            continue
        timed = [i for i, one in enumerate(headers) if one.lower() in _TIME_HEADERS]
        given = [i for i, one in enumerate(event.node.args) if isinstance(one, ast.Name) and one.id == "t"]
        if len(timed) == len(given) == 1 and timed != given:
            message = f"the time 't' goes below '{headers[given[0]]}', and not below '{headers[timed[0]]}'"
            yield function.declared.finding(Code.NRP240, event.node, message, Level.WARNING)


@checks_function(Code.NRP240)
def adapters_have_the_attribute(function: CheckedFunction) -> Iterator[Finding]:
    """Look for attributes that a parameter's device, topic or variable does not have."""
    for event in function.events:
        if isinstance(event, (Read, Write)) and not event.exists and _adapter(event) is not None:
            hint = attribute_hint(event.name, names_of(event.owner))
            message = f"{_described(function, event)} has no attribute '{event.name}'{hint}"
            yield function.declared.finding(Code.NRP240, event.node, message, instead=hint.instead)


@checks_function(Code.NRP240)
def numbers_have_no_attributes(function: CheckedFunction) -> Iterator[Finding]:
    """Look for attributes of numbers, such as those of the device that a number was read from."""
    for event in function.events:
        if isinstance(event, (Read, Write)) and not event.exists and isinstance(event.owner, Number):
            message = f"'{ast.unparse(event.node.value)}' is a number and has no '{event.name}'"
            yield function.declared.finding(Code.NRP240, event.node, message)


@checks_function(Code.NRP240)
def functions_are_called_before_their_result_is_read(function: CheckedFunction) -> Iterator[Finding]:
    """Look for attributes of functions and classes that belong to their results."""
    for event in function.events:
        match event:
            case Read(node, Known(value) as owner, name) if not hasattr(value, name):
                if message := not_called(owner):
                    yield function.declared.finding(Code.NRP240, node, message)


@checks_function(Code.NRP240)
def messages_have_the_field(function: CheckedFunction) -> Iterator[Finding]:
    """Look for fields that a message does not have."""
    for event in function.events:
        if isinstance(event, (Read, Write)) and not event.exists and isinstance(event.owner, Instance):
            hint = did_you_mean(event.name, names_of(event.owner))
            message = f"{type_name(event.owner.cls)} has no field '{event.name}'{hint}"
            yield function.declared.finding(Code.NRP240, event.node, message, instead=hint.instead)


@checks_function(Code.NRP240)
def modules_have_the_name(function: CheckedFunction) -> Iterator[Finding]:
    """Look for names that a module does not have."""
    for event in function.events:
        match event:
            case Read(node, Known(ModuleType()) | Names(), _, False):
                message, instead = missing_name(event)
                yield function.declared.finding(Code.NRP240, node, message, instead=instead)


@checks_function(Code.NRP240)
def only_writable_attributes_are_set(function: CheckedFunction) -> Iterator[Finding]:
    """Look for read-only attributes that are set."""
    for event in function.events:
        adapter = _adapter(event) if isinstance(event, Write) and event.exists else None
        if adapter is not None and isinstance(event, Write) and not can_set(adapter, event.name):
            level = Level.WARNING if isinstance(adapter, SubscribedTopic) else Level.ERROR
            message = f"{_described(function, event).rstrip(',')}: '{event.name}' is read-only"
            yield function.declared.finding(Code.NRP240, event.node, message, level)


@checks_function(Code.NRP240)
def settings_are_in_range(function: CheckedFunction) -> Iterator[Finding]:
    """Assign constants to a device that is not connected, to find invalid ones."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup() as device), name, True, Known(value)):
                pass
            case Write(node, Known(Device() | DeviceGroup() as device), name, True, Row(items)) if all(
                isinstance(item, Known) for item in items
            ):
                value = [item.value for item in items if isinstance(item, Known)]
            case _:
                continue
        if not can_set(device, name) or isinstance(value, Adapter):
            continue
        before = getattr(device, name)
        try:
            setattr(device, name, value)
            setattr(device, name, before)
        except (ValueError, TypeError) as error:
            plain = isinstance(value, (int, float, list, tuple))
            message = str(error) if plain else f"'{name}' takes a number, not {value!r:.40}"
            yield function.declared.finding(Code.NRP240, node, message)


def _adapter(event: Read | Write) -> Adapter | None:
    owner = event.owner.value if isinstance(event.owner, Known) else None
    return owner if isinstance(owner, Adapter) else None


def _described(function: CheckedFunction, event: Read | Write) -> str:
    """Return a short description of a parameter."""
    adapter = _adapter(event)
    name = function.parameter_of(event.owner)
    mapping = function.function.mappings.get(name or "")
    if isinstance(mapping, (MapSpikeSink, MapSpikeSource)):
        side = "source" if mapping.drives else "sink"
        group = "group of " if isinstance(adapter, DeviceGroup) else ""
        return f"'{name}', a {group}{mapping.kind} ({side}),"
    kinds = {
        SubscribedTopic: "a subscribed topic",
        PublishedTopic: "a published topic",
        Variable: "a variable",
    }
    text = next((text for kind, text in kinds.items() if isinstance(adapter, kind)), "")
    if name is None:
        return text or f"a {type(adapter).__name__}"
    return f"'{name}', {text}," if text else f"'{name}'"
