"""Operations on devices, topics, messages and values that fail: attributes, calls, items, computations."""

from __future__ import annotations

import ast
import dataclasses
import inspect
from collections.abc import Iterable, Iterator
from math import isnan
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any, Final, NamedTuple

import numpy as np

from nrp_core.checks.code.declarations import missing_name
from nrp_core.checks.code.statements import Written
from nrp_core.checks.code.values import (
    DEVICE_UNITS,
    NUMERIC,
    Instance,
    Known,
    Shape,
    adapter_of,
    can_set,
    class_of,
    has_attribute,
    hints,
    is_message,
    is_number,
    item_of,
    names_of,
    value_of,
)
from nrp_core.checks.static_experiment import CheckedFunction, checks_function, sent_value
from nrp_core.dsl.devices import Device, DeviceGroup, attribute_hint
from nrp_core.dsl.mappings import CSVRecorder, MapSpikeSink, MapSpikeSource, Variable
from nrp_core.dsl.parameters import PublishedTopic, SubscribedTopic
from nrp_core.dsl.weights import Weights
from nrp_core.errors import Instead, TopicError, did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.base import type_name
from nrp_core.world.topics import TopicInfo, check_message

_FUNCTIONS: Final = (FunctionType, MethodType, BuiltinFunctionType, Written, np.ufunc)
_MAIN_ATTRIBUTES: Final = ("value", "voltage", "rate", "times", "amplitude", "mean")
"""The main attribute of a device, topic or variable."""
_KINDS: Final = {
    SubscribedTopic: "subscribed topic",
    PublishedTopic: "published topic",
    Variable: "variable",
}
_ARITHMETIC: Final = ("__add__", "__radd__", "__mul__", "__rmul__", "__float__")
_ORDERS: Final = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
_FIELD_TYPES: Final[dict[Any, tuple[str, tuple[type, ...]]]] = {
    float: ("a number", (int, float)),
    int: ("a whole number", (int,)),
    bool: ("true or false", (bool, int)),
    str: ("a text", (str,)),
}


class _Failure(NamedTuple):
    """An operation that fails."""

    node: ast.AST
    message: str
    level: Level = Level.ERROR
    instead: Instead | None = None


@checks_function
def check_operations(function: CheckedFunction) -> Iterator[Finding]:
    """Look for attributes, settings, calls, items, computations and messages that fail."""
    for failures in (_attribute, _setting, _weights, _call, _items, _computation, _sent_value, _row):
        for node in function.body.nodes:
            for failure in failures(function, node):
                yield function.declared.finding(Code.NRP240, *failure)


# -- attributes


def _attribute(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield an attribute that does not exist or cannot be set."""
    if not isinstance(node, ast.Attribute):
        return
    owner = function.body.shape(node.value)
    adapter = adapter_of(owner)
    if not has_attribute(owner, node.attr):
        message, instead = _missing_attribute(function, node, owner)
        yield _Failure(node, message, instead=instead)
    elif adapter is not None and isinstance(node.ctx, ast.Store) and not can_set(adapter, node.attr):
        level = Level.WARNING if isinstance(adapter, SubscribedTopic) else Level.ERROR
        yield _Failure(node, f"{_described(function, owner)}: '{node.attr}' is read-only", level)


def _missing_attribute(function: CheckedFunction, node: ast.Attribute, owner: Shape) -> tuple[str, Any]:
    """Return the message about an attribute that does not exist, and the one to replace it with."""
    written = ast.unparse(node.value)
    if adapter_of(owner) is not None:
        hint = attribute_hint(node.attr, names_of(owner))
        return f"{_described(function, owner)}, has no attribute '{node.attr}'{hint}", hint.instead
    if value_of(owner, ModuleType) is not None:
        return missing_name(owner, node)
    if is_number(owner):
        return f"'{written}' is a number and has no '{node.attr}'", None
    if uncalled := _not_called(owner):
        return uncalled, None
    hint = did_you_mean(node.attr, names_of(owner))
    cls = class_of(owner)
    return f"{type_name(cls) if cls else written} has no field '{node.attr}'{hint}", hint.instead


def _described(function: CheckedFunction, owner: Shape) -> str:
    """Return a short description of a parameter."""
    adapter, name = adapter_of(owner), function.parameter_of(owner)
    mapping = function.function.mappings.get(name or "")
    if isinstance(mapping, MapSpikeSink | MapSpikeSource):
        side = "source" if mapping.drives else "sink"
        group = "group of " if isinstance(adapter, DeviceGroup) else ""
        return f"'{name}', a {group}{mapping.kind} ({side})"
    kind = _KINDS.get(type(adapter), type(adapter).__name__)
    return f"a {kind}" if name is None else f"'{name}', a {kind}"


def _not_called(shape: Shape) -> str:
    """Return that a value is a function or class, as one without its parentheses is; empty if not."""
    value = value_of(shape)
    kind = "class" if isinstance(value, type) else "function" if isinstance(value, _FUNCTIONS) else ""
    return f"'{value.__name__}' is a {kind}, not a value; call it: {value.__name__}(...)" if kind else ""


# -- settings of devices, and fields of messages


def _setting(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield wrong fields, and settings that a device refuses: constants are tried on one without a brain."""
    for target, value in _assignments(node):
        owner, shape = function.body.shape(target.value), function.body.shape(value)
        device, name, cls = adapter_of(owner), target.attr, class_of(owner)
        if cls is not None and is_message(cls):
            if wrong := _misfit(function, shape, hints(cls).get(name)):
                yield _Failure(target, f"{name} of {type_name(cls)} must be {wrong}")
            continue
        if not isinstance(device, Device | DeviceGroup) or not _is_setting(device, name):
            continue
        is_row = isinstance(value, ast.List | ast.Tuple)
        items = list(map(function.body.shape, value.elts)) if is_row else [shape]  # type: ignore[attr-defined]
        if wrong := _first(_no_number(function, one) for one in items):
            yield _Failure(target, f"'{name}' takes a number: {wrong}")
        elif isinstance(value, ast.Compare) or any(class_of(one) is bool for one in items):
            unit = DEVICE_UNITS.get(name, "")
            message = (
                f"'{name}' is in {unit} and is set to true or false, which is 1 or 0 {unit}; "
                "write the value: 100.0 if ... else 0.0"
            )
            yield _Failure(target, message, Level.WARNING)
        elif message := _refused_setting(device, name, shape, len(items) if is_row else None):
            yield _Failure(target, message)


def _assignments(node: ast.AST) -> Iterator[tuple[ast.Attribute, ast.expr]]:
    """Yield the attributes that a statement sets, with the value of each."""
    match node:
        case ast.Assign([ast.Attribute() as target], value):
            yield target, value
        case ast.Assign([ast.Tuple(targets)], ast.Tuple(values)):
            pairs = zip(targets, values, strict=False)
            yield from ((one, other) for one, other in pairs if isinstance(one, ast.Attribute))


def _is_setting(device: Device | DeviceGroup, name: str) -> bool:
    return name in DEVICE_UNITS and has_attribute(Known(device), name) and can_set(device, name)


def _refused_setting(device: Device | DeviceGroup, name: str, shape: Shape, n_items: int | None) -> str:
    """Return why a device refuses a value; empty if it does not, or if the value is unknown.

    Args:
        device: the device.
        name: the setting.
        shape: the value.
        n_items: the number of values in a row.
    """
    if not isinstance(shape, Known):
        is_misfit = n_items is not None and isinstance(device, DeviceGroup) and n_items != len(device)
        return f"{n_items} values for '{name}' of {len(device)} devices" if is_misfit else ""
    before = getattr(device, name)
    try:
        setattr(device, name, shape.value)
        setattr(device, name, before)
    except (ValueError, TypeError) as error:
        is_plain = isinstance(shape.value, int | float | list | tuple)
        return str(error) if is_plain else f"'{name}' takes a number, not {shape.value!r:.40}"
    return ""


def _weights(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield weights that are set or frozen and cannot be."""
    match node:
        case ast.Subscript(ast.Attribute(owner, "values" as name), _, ast.Store()) | ast.Attribute(
            owner, "values" | "plastic" as name, ast.Store()
        ):
            adapter, backend = adapter_of(function.body.shape(owner)), function.experiment.brain.backend
            if isinstance(adapter, Weights) and (why := adapter.refusal(name, backend)):
                yield _Failure(node, f"{_described(function, Known(adapter))}: {why}")


# -- calls


def _call(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield a call of something else than a function, or with arguments that do not fit."""
    if not isinstance(node, ast.Call):
        return
    callee = function.body.shape(node.func)
    value, cls = value_of(callee), class_of(callee)
    is_callable = callable(value) if isinstance(callee, Known) else cls is None or callable(cls)
    is_whole = not any(isinstance(one, ast.Starred) for one in node.args)
    if not is_callable or is_number(callee):
        yield _Failure(node, f"'{ast.unparse(node.func)}' is not a function and cannot be called")
    elif _has_known_signature(value) and is_whole and all(one.arg for one in node.keywords):
        yield from _arguments(function, node, value)


def _has_known_signature(callee: Any) -> bool:
    if isinstance(callee, FunctionType | MethodType):
        return str(callee.__module__).startswith("nrp_core.")
    if not isinstance(callee, BuiltinFunctionType) or callee.__module__ not in ("math", "builtins"):
        return isinstance(callee, Written) or is_message(callee)
    try:
        return bool(inspect.signature(callee).parameters)
    except ValueError:
        return False


def _arguments(function: CheckedFunction, node: ast.Call, callee: Any) -> Iterator[_Failure]:
    signature = inspect.signature(callee)
    named = {str(one.arg): one.value for one in node.keywords}
    try:
        bound = signature.bind(*node.args, **named)
    except TypeError as error:
        name = type_name(callee) if is_message(callee) else callee.__name__
        yield _Failure(node, f"{name}({', '.join(signature.parameters)}): {error}")
        return
    for name, value in bound.arguments.items() if is_message(callee) else ():
        if wrong := _misfit(function, function.body.shape(value), hints(callee).get(name)):
            yield _Failure(node, f"{name} of {type_name(callee)} must be {wrong}")


# -- items


def _items(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield items of a value without items, and indices beyond a group of devices."""
    match node:
        case ast.Subscript(value, index):
            place = value_of(function.body.shape(index), int)
        case ast.For(_, value):
            place = None
        case _:
            return
    owner, written = function.body.shape(value), ast.unparse(value)
    group, cls = value_of(owner, DeviceGroup), class_of(owner)
    if group is not None and place is not None and not -len(group) <= place < len(group):
        message = f"'{written}' has {len(group)} devices, 0..{len(group) - 1}; {place} is out of range"
        yield _Failure(node, message)
    is_message_without = is_message(cls) and not hasattr(cls, "__getattr__")
    is_known = is_number(owner) or adapter_of(owner) is not None or is_message_without
    if is_known and not (hasattr(cls, "__getitem__") or hasattr(cls, "__iter__")):
        yield _Failure(node if isinstance(node, ast.expr) else value, f"'{written}' has no items")


# -- computations


def _computation(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield a value that is not a number in a computation or as an argument of a numeric function."""
    shape, wrong = function.body.shape, ""
    match node:
        case ast.BinOp(left, operation, right):
            wrong = _wrong_operands(function, operation, left, right)
        case ast.AugAssign(target, operation, value):
            loaded = ast.copy_location(ast.parse(ast.unparse(target), mode="eval").body, target)
            wrong = _wrong_operands(function, operation, loaded, value)
        case ast.UnaryOp(ast.USub() | ast.UAdd(), operand):
            wrong = _no_number(function, shape(operand))
        case ast.Compare(left, orders, others) if all(isinstance(one, _ORDERS) for one in orders):
            wrong = _first(_no_number(function, shape(one), is_operand=True) for one in (left, *others))
        case ast.Call(func, given, named):
            if _takes_values(value_of(shape(func))):
                values = (*given, *(each.value for each in named))
                wrong = _first(_no_value(function, shape(one)) for one in values)
    if wrong:
        yield _Failure(node, wrong)


def _first(reasons: Iterable[str]) -> str:
    """Return the first text that is not empty."""
    return next(filter(None, reasons), "")


def _wrong_operands(
    function: CheckedFunction, operation: ast.operator, left: ast.expr, right: ast.expr
) -> str:
    """Return why two values cannot be combined; empty if they can or if they are unknown."""
    shapes = function.body.shape(left), function.body.shape(right)
    if wrong := _first(_no_number(function, one, is_operand=True) for one in shapes):
        return wrong
    n_texts = sum(class_of(one) is str for one in shapes)
    if n_texts == 1 and any(map(is_number, shapes)) and isinstance(operation, ast.Add):
        return "a text and a number cannot be combined; write f'...{number}', or float(text)"
    if isinstance(operation, ast.Mod) and not is_number(shapes[0]):  # a text is formatted
        return ""
    are_lists = [isinstance(one, Instance) and one.cls is list and is_number(item_of(one)) for one in shapes]
    if any(are_lists) and any(type(value_of(one)) is float for one in shapes):  # a NumPy function works
        return "a list and a number cannot be combined: [2.0 * one for one in ...]"
    return _first(map(_never_a_number, shapes))


def _takes_values(callee: Any) -> bool:
    """Return whether a function takes numbers or messages only, and not devices or topics."""
    if any(callee is one for one in NUMERIC):
        return True
    is_function = isinstance(callee, FunctionType | MethodType) or type(callee).__module__.startswith("numpy")
    modules = ("nrp_core.dsl.tf_lib", "nrp_core.dsl.messages", "nrp_core.dsl.parameters", "numpy")
    return is_function and str(getattr(callee, "__module__", "")).startswith(modules)


def _no_number(function: CheckedFunction, shape: Shape, *, is_operand: bool = False) -> str:
    """Return why a value cannot be used in a computation; empty if it can or if it is unknown."""
    if is_operand and isinstance(adapter_of(shape), DeviceGroup):
        return f"'{function.parameter_of(shape)}' is a group of devices, not a value"
    cls = class_of(shape)
    if dataclasses.is_dataclass(cls) and not any(hasattr(cls, name) for name in _ARITHMETIC):
        name = type_name(cls) if hasattr(cls, "__msgtype__") else cls.__name__
        return f"a {name} is not a number; its fields are {', '.join(names_of(shape)[:4])}"
    return _no_value(function, shape)


def _no_value(function: CheckedFunction, shape: Shape) -> str:
    """Return why a parameter is not a value; empty if it may be one."""
    adapter = adapter_of(shape)
    if adapter is None or isinstance(adapter, DeviceGroup) or hasattr(type(adapter), "__add__"):
        return ""
    name = function.parameter_of(shape) or "it"
    meant = next((one for one in _MAIN_ATTRIBUTES if one in names_of(shape)), "")
    hint = f"; did you mean '{name}.{meant}'?" if meant else ""
    return f"'{name}' is a {_KINDS.get(type(adapter), 'device')}, not a value{hint}"


def _never_a_number(shape: Shape) -> str:
    """Return why a value is not a number: it is None, nan, or a function without its call."""
    match shape:
        case Known(None):
            return "None is not a number"
        case Known(float() as value) if isnan(value):
            return "the result is always nan, which topics and devices refuse"
    return _not_called(shape)


# -- messages


def _sent_value(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield a returned or sent value that does not fit its topic."""
    if (sent := sent_value(function, node)) is not None:
        info, value = sent
        shape = function.body.shape(value)
        if wrong := _no_value(function, shape) or _refused_value(info, shape):
            yield _Failure(node, wrong)


def _refused_value(info: TopicInfo, shape: Shape) -> str:
    """Return why a topic would refuse a value; empty if it is not known to."""
    if not dataclasses.is_dataclass(info.type):
        return ""
    kind: Any = info.type
    carried, is_single = f"{info.name} carries {type_name(kind)}", len(dataclasses.fields(kind)) == 1
    cls = class_of(shape)
    match shape:
        case Known(type() as other):
            return f"{carried}, not its class; did you mean '{other.__name__}()'?"
        case Instance(cls) if is_message(cls) and type_name(cls) != type_name(kind):
            return f"{carried}, not {type_name(cls)}"
        case Instance() | Known(list() | tuple()) if cls in (list, tuple):
            return f"{carried}, not a list"
        case Instance() if is_number(shape) and not is_single:
            return f"{carried}, not a number"
        case Known(bool() | int() | float() | str() as plain):
            try:
                check_message(info, kind(plain) if is_single else plain)
            except TopicError as error:
                return error.message
    return ""


def _misfit(function: CheckedFunction, shape: Shape, hint: Any) -> str:
    """Return the type of a field if a value does not fit it, else an empty text."""
    if wrong := _no_value(function, shape) or _not_called(shape):
        return f"a value: {wrong}"
    cls = class_of(shape)
    if cls is None or cls is hint or (isinstance(hint, type) and issubclass(cls, hint)):
        return ""
    is_plain = cls in (int, float, bool, str, list, tuple, type(None)) or is_message(cls)
    given = repr(shape.value)[:40] if isinstance(shape, Known) else _kind_of(cls)
    if is_message(hint):
        return f"a {type_name(hint)}, not {given}" if is_plain and type_name(cls) != type_name(hint) else ""
    wanted, accepted = _FIELD_TYPES.get(hint, ("", (object,)))
    is_rounded = hint is int and cls is float and not isinstance(shape, Known)
    is_misfit = wanted and is_plain and not issubclass(cls, accepted) and not is_rounded
    return f"{wanted}, not {given}" if is_misfit else ""


def _kind_of(cls: type) -> str:
    if is_message(cls):
        return f"a {type_name(cls)}"
    return "a list" if cls in (list, tuple) else "a text" if cls is str else "a number"


# -- recorders


def _row(function: CheckedFunction, node: ast.AST) -> Iterator[_Failure]:
    """Yield a row of a recorder that does not have a value for each header."""
    match node:
        case ast.Call(ast.Attribute(owner, "record_entry"), values, []):
            recorder = adapter_of(function.body.shape(owner))
            is_whole = not any(isinstance(one, ast.Starred) for one in values)
            if isinstance(recorder, CSVRecorder) and is_whole and len(values) != len(recorder.headers):
                headers = ", ".join(recorder.headers)
                message = f"a row of {len(values)} under {len(recorder.headers)} headers: {headers}"
                yield _Failure(node, message, Level.WARNING)
