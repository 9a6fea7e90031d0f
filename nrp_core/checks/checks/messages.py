"""How messages are created and where they are sent."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from types import MethodType
from typing import Any, cast

from nrp_core.checks.checks.values import no_value, not_called
from nrp_core.checks.events import Call, Return, Write
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Items, Known, Number, Row, Shape, hints
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.parameters.topics import PublishedTopic
from nrp_core.errors import TopicError
from nrp_core.findings import Code, Finding
from nrp_core.world.messages.base import type_name
from nrp_core.world.topics import TopicInfo, check_message

_PLAIN: dict[Any, tuple[str, tuple[type, ...]]] = {
    float: ("a number", (int, float)),
    int: ("a whole number", (int,)),
    bool: ("true or false", (bool, int)),
    str: ("a text", (str,)),
}


@checks_function(Code.NRP227)
def constructor_arguments_have_the_field_types(function: CheckedFunction) -> Iterator[Finding]:
    """Compare the arguments of messages with their fields."""
    for event in function.events:
        match event:
            case Call(node, Known(type() as cls), given, named, True) if _is_message(cls):
                try:
                    bound = inspect.signature(cls).bind(*given, **named)
                except TypeError as error:
                    fields = ", ".join(field.name for field in dataclasses.fields(cls))
                    message = f"{type_name(cls)}({fields}): {error}"
                    yield function.declared.finding(Code.NRP227, node, message)
                    continue
                for name, shape in bound.arguments.items():
                    wrong = _misfit(function, shape, hints(cls).get(name))
                    if wrong:
                        message = f"{name} of {type_name(cls)} must be {wrong}"
                        yield function.declared.finding(Code.NRP227, node, message)


@checks_function(Code.NRP227)
def assigned_values_have_the_field_types(function: CheckedFunction) -> Iterator[Finding]:
    """Compare values assigned to fields of messages with the types of the fields."""
    for event in function.events:
        match event:
            case Write(node, Instance(cls), name, True, value) if _is_message(cls):
                wrong = _misfit(function, value, hints(cls).get(name))
                if wrong:
                    message = f"{name} of {type_name(cls)} must be {wrong}"
                    yield function.declared.finding(Code.NRP227, node, message)


@checks_function(Code.NRP228)
def sent_values_fit_the_topic(function: CheckedFunction) -> Iterator[Finding]:
    """Compare returned and sent values with the type of the topic."""
    for event in function.events:
        match event:
            case Return(node, value) if value is not None and function.returns_to is not None:
                info = function.returns_to
            case Call(node, Known(MethodType() as method), (value,), named, True) if (
                _sends(method) and not named
            ):
                info = cast(PublishedTopic, method.__self__).info
            case _:
                continue
        wrong = _refused(info, value)
        if wrong:
            yield function.declared.finding(Code.NRP228, node, wrong)


def _refused(info: TopicInfo, value: Shape) -> str:
    """Return why a topic would refuse a value; empty if it is not known to."""
    if not dataclasses.is_dataclass(info.type):
        return ""
    kind: Any = info.type
    fields = dataclasses.fields(kind)
    match value:
        case Instance(cls) if type_name(cls) != type_name(info.type):
            return f"{info.name} carries {type_name(info.type)}, not {type_name(cls)}"
        case Known(type() as cls):
            return (
                f"{info.name} carries {type_name(info.type)}, not its class; did you mean '{cls.__name__}()'?"
            )
        case Number() | Items() | Row() if isinstance(value, (Items, Row)) or len(fields) != 1:
            what = "a number" if isinstance(value, Number) else "a list"
            return f"{info.name} carries {type_name(info.type)}, not {what}"
        case Known(bool() | int() | float() | str() as plain):
            try:
                check_message(info, kind(plain) if len(fields) == 1 else plain)
            except TopicError as error:
                return error.message
    return ""


def _misfit(function: CheckedFunction, shape: Shape, hint: Any) -> str:
    """Return the type of a field if a value does not fit it, else an empty text."""
    wrong = no_value(function, shape) or not_called(shape)
    if wrong:
        return f"a value: {wrong}"
    is_message = dataclasses.is_dataclass(hint) and isinstance(hint, type)
    return _no_message(shape, hint) if is_message else _no_plain_value(shape, hint)


def _no_message(shape: Shape, hint: type) -> str:
    wanted = f"a {type_name(hint)}"
    match shape:
        case Instance(cls) if type_name(cls) != type_name(hint):
            return f"{wanted}, not a {type_name(cls)}"
        case Number():
            return f"{wanted}, not a number"
        case Items() | Row():
            return f"{wanted}, not a list"
        case Known(int() | float() | str() | None as value):
            return f"{wanted}, not {value!r:.40}"
    return ""


def _no_plain_value(shape: Shape, hint: Any) -> str:
    wanted, accepted = _PLAIN.get(hint, ("", (object,)))
    match shape:
        case Known(bool() | int() | float() | str() | None as plain) if not isinstance(plain, accepted):
            return f"{wanted}, not {plain!r:.40}"
        case Instance(cls) if wanted and cls is not hint:
            return f"{wanted}, not a {type_name(cls)}"
        case Items() | Row() if wanted:
            return f"{wanted}, not a list"
        case Number() if hint is str:
            return f"{wanted}, not a number"
    return ""


def _is_message(cls: type) -> bool:
    return dataclasses.is_dataclass(cls) and hasattr(cls, "__msgtype__")


def _sends(method: MethodType) -> bool:
    return isinstance(method.__self__, PublishedTopic) and method.__name__ == "send_message"
