"""Devices, topics and messages that are used in place of a number."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from math import isnan
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

import numpy as np

from nrp_core.checks.events import Add, Call, Compute, Divide, Multiply, Return, Write
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import UNITS, Instance, Items, Known, Number, Row, Shape, names_of
from nrp_core.checks.statements import Written
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name

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


@checks_function(Code.NRP225)
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
                    yield function.declared.finding(Code.NRP225, node, message)
                elif id(node) in compared or any(one == Instance(bool) or _is(one, bool) for one in shapes):
                    message = _truth_value(name, UNITS[name])
                    yield function.declared.finding(Code.NRP225, node, message, Level.WARNING)


def _takes_values(callee: Any) -> bool:
    """Return whether a function takes numbers or messages only, and not devices or topics."""
    if any(callee is one for one in _OF_VALUES):
        return True
    if not isinstance(callee, (FunctionType, MethodType)) and not type(callee).__module__.startswith("numpy"):
        return False
    module = str(getattr(callee, "__module__", ""))
    return module.startswith(("nrp_core.dsl.tf_lib", "nrp_core.dsl.parameters.topics", "numpy"))


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
