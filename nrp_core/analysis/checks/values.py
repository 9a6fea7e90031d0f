"""Devices, topics and messages that stand where a number is meant."""

from __future__ import annotations

from collections.abc import Iterator
from types import FunctionType, MethodType
from typing import Any

from nrp_core.analysis.events import Call, Compute, Return, Write
from nrp_core.analysis.registry import checks_function
from nrp_core.analysis.shapes import UNITS, Instance, Known, Row, Shape, names_of
from nrp_core.analysis.study import Examined
from nrp_core.dsl.binding import Adapter
from nrp_core.dsl.devices import Device
from nrp_core.dsl.groups import DeviceGroup
from nrp_core.findings import Code, Finding
from nrp_core.world.messages.base import type_name

_OF_NUMBERS: tuple[Any, ...] = (min, max, abs, float, int, round, sum)
_TELLING = ("value", "voltage", "rate", "times", "amplitude", "mean")
"""What is mostly meant of a device, topic or variable."""
_ARITHMETIC = ("__add__", "__radd__", "__sub__", "__mul__", "__rmul__", "__truediv__", "__neg__", "__float__")


@checks_function(Code.NRP247)
def numbers_are_computed_with(function: Examined) -> Iterator[Finding]:
    """Look for what is no number in computations, and in arguments of functions that take numbers."""
    for event in function.events:
        match event:
            case Compute(node, operand):
                wrong = _no_number(function, operand)
            case Return(node, Known(Adapter()) as given) if function.returns_to is not None:
                wrong = _no_number(function, given)
            case Call(node, Known(callee), given, named):
                if not _takes_values(callee):
                    continue
                shapes = [*given, *named.values()]
                wrong = next(filter(None, (_no_value(function, one) for one in shapes)), "")
            case _:
                continue
        if wrong:
            yield function.declared.finding(Code.NRP247, node, wrong)


@checks_function(Code.NRP225)
def settings_are_numbers(function: Examined) -> Iterator[Finding]:
    """Look for settings of devices that are given what is no number."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, value) if name in UNITS:
                shapes = value.items if isinstance(value, Row) else (value,)
                wrong = next(filter(None, (_no_number(function, shape) for shape in shapes)), "")
                if wrong:
                    message = f"'{name}' takes a number: {wrong}"
                    yield function.declared.finding(Code.NRP225, node, message)


def _takes_values(callee: Any) -> bool:
    """Whether a function takes numbers or messages, and nothing that a parameter stands for."""
    if any(callee is one for one in _OF_NUMBERS):
        return True
    if not isinstance(callee, (FunctionType, MethodType)) and not type(callee).__module__.startswith("numpy"):
        return False
    module = str(getattr(callee, "__module__", ""))
    return module.startswith(("nrp_core.dsl.tf_lib", "nrp_core.dsl.topics", "numpy"))


def _no_number(function: Examined, shape: Shape) -> str:
    """Return why something cannot be computed with, empty where it can or nothing is known."""
    match shape:
        case Instance(cls) if not any(hasattr(cls, name) for name in _ARITHMETIC):
            name = type_name(cls) if hasattr(cls, "__msgtype__") else cls.__name__
            told = ", ".join(names_of(shape)[:4])
            return f"a {name} is no number; its fields are {told}"
    return _no_value(function, shape)


def _no_value(function: Examined, shape: Shape) -> str:
    match shape:
        case Known(DeviceGroup()):
            return ""
        case Known(Adapter() as adapter) if not any(hasattr(type(adapter), name) for name in _ARITHMETIC):
            name = function.parameter_of(shape) or "it"
            meant = next((one for one in _TELLING if one in names_of(shape)), "")
            hint = f"; did you mean '{name}.{meant}'?" if meant else ""
            return f"'{name}' stands for a {_kind(adapter)}, not for a value{hint}"
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
