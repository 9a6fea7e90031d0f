"""Classes of ROS 2 for messages, services and actions: those of this installation, else made here.

A class that is made here has the attributes and the type support that ROS's generators give to theirs, so
that ``rclpy`` treats both alike.
"""

from __future__ import annotations

import os
import sys
from array import array
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from nrp_core.errors import BackendLoadError, TopicError
from nrp_core.messages.base import type_of
from nrp_core.messages.cdr import Codec, MessageField

from nrp_world_ros.ros2.definitions import PARTS, define
from nrp_world_ros.ros2.typesupport import MIDDLEWARES, TypeSupport

_made: dict[str, Any] = {}
"""The classes that were made here, by type."""

_INFO = "service_msgs/msg/ServiceEventInfo"


class RosTypes:
    """The classes of messages, services and actions.

    Args:
        codec: has the definitions.
    """

    def __init__(self, codec: Codec) -> None:
        self._codec = codec

    def message(self, name: str) -> Any:
        """Return the class of a message type, ``package/msg/Type``.

        Raises:
            TopicError: this ROS has a type of that name with other fields.
            BackendLoadError: it lacks the type, which cannot be made.
        """
        cls = self.named(name)
        self._compare(name, cls)
        return cls

    def service(self, request: str, response: str) -> Any:
        """Return the class of a service with these types, ``package/msg/NameRequest`` and ``...Response``.

        Raises:
            TopicError: this ROS has a service of that name with other fields.
            BackendLoadError: it lacks the service, which cannot be made.
        """
        cls = self.named(request.replace("/msg/", "/srv/").removesuffix("Request"))
        self._compare(request, cls.Request)
        self._compare(response, cls.Response)
        return cls

    def named(self, name: str) -> Any:
        """Return the class of a type, ``package/kind/Type``, of this ROS or made here.

        Raises:
            BackendLoadError: this ROS lacks the type, which cannot be made.
            TopicError: the type is unknown.
        """
        return _made.get(name) or _installed(*name.split("/")) or self.make(name)

    def make(self, name: str) -> Any:
        """Return the class of a type, ``package/kind/Type``, that this ROS lacks.

        Raises:
            BackendLoadError: its middleware needs C code of each type.
            TopicError: the type is unknown.
        """
        if name not in _made:
            kind = name.split("/")[1]
            self._define(name)
            _made[name] = {"msg": self._message, "srv": self._service, "action": self._action}[kind](name)
        return _made[name]

    def _compare(self, name: str, cls: Any) -> None:
        theirs, ours = list(cls.get_fields_and_field_types()), self._codec.fields(name)
        if theirs and theirs != [field.name for field in ours]:
            raise TopicError(
                f"{name} has the fields {theirs} in this ROS 2, but {[field.name for field in ours]} here"
            )

    # -- the types that this ROS lacks

    def _define(self, name: str) -> None:
        """Add the types of a service or action, and of what it consists of, under ROS's names."""
        package, kind, short = name.split("/")
        define(self._codec)
        for part in PARTS[kind]:
            ours = f"{package}/msg/{short}{part}"
            if (cls := type_of(ours)) is not None:
                ours = self._codec.name(cls)
            try:
                fields = self._codec.fields(ours)
            except KeyError:
                raise TopicError(f"this installation of ROS 2 lacks {name}, which is unknown here") from None
            if part:
                self._codec.compose(f"{name}_{part}", fields, ours)
        if kind == "srv":
            self._define_service(name)
        if kind == "action":
            for inner, fields in _action_types(name).items():
                self._codec.compose(inner, fields)
            self._define_service(f"{name}_SendGoal")
            self._define_service(f"{name}_GetResult")

    def _define_service(self, name: str) -> None:
        request, response, event = (f"{name}_{part}" for part in ("Request", "Response", "Event"))
        calls = [MessageField("request", request, True, 1), MessageField("response", response, True, 1)]
        self._codec.compose(event, [MessageField("info", _INFO), *calls])
        ends = zip(("request", "response", "event"), (request, response, event), strict=True)
        self._codec.compose(name, [MessageField(f"{end}_message", kind) for end, kind in ends])

    def _message(self, name: str) -> Any:
        codec, fields = self._codec, self._fields(name)

        def decode(data: bytes) -> Any:
            return self._convert(name, codec.decode(data, name))

        content = {
            "__init__": _initializer({each.name: self._default(each) for each in fields}),
            "__eq__": _are_equal,
            "__hash__": None,
            "__repr__": _described,
            "get_fields_and_field_types": classmethod(
                lambda _cls: {each.name: _text(each) for each in fields}
            ),
            "structure_needs_at_least_one_member": 0,
            **codec.constants(name),
        }
        encode: Callable[[Any], bytes] = lambda message: bytes(codec.encode_as(message, name))  # noqa: E731
        empty: Callable[[], Any] = lambda: self._inner(name)()  # noqa: E731
        return _class(name, content, _support().message(name, codec.hash(name), encode, decode, empty))

    def _service(self, name: str) -> Any:
        ends = [self._message_once(f"{name}_{end}") for end in ("Request", "Response")]
        content = dict(zip(("Request", "Response"), ends, strict=True))
        return _class(name, content, _support().service(name, self._codec.hash(name), *ends))

    def _action(self, name: str) -> Any:
        parts = {part: self._message_once(f"{name}_{part}") for part in PARTS["action"]}
        inner = {
            "SendGoalService": self._service(f"{name}_SendGoal"),
            "GetResultService": self._service(f"{name}_GetResult"),
            "CancelGoalService": self.named("action_msgs/srv/CancelGoal"),
            "FeedbackMessage": self._message_once(f"{name}_FeedbackMessage"),
            "GoalStatusMessage": self.named("action_msgs/msg/GoalStatusArray"),
        }
        support = _support().action(name, self._codec.hash(name), inner.values())
        return _class(name, {**parts, "Impl": type("Impl", (), inner)}, support)

    def _message_once(self, name: str) -> Any:
        if name not in _made:
            _made[name] = self._message(name)
        return _made[name]

    def _fields(self, name: str) -> list[MessageField]:
        return [
            each for each in self._codec.fields(name) if each.name != "structure_needs_at_least_one_member"
        ]

    def _inner(self, name: str) -> Any:
        """Return the class of a field's type, which may be a part of an action."""
        return self.named(name) if "/msg/" in name else self._message_once(name)

    def _default(self, field: MessageField) -> Callable[[], Any]:
        one: Callable[[], Any] = (
            self._inner(field.type) if "/" in field.type else _PLAIN.get(field.type[:3], int)
        )
        if field.many or field.length is not None:
            return lambda: _items(field, [one() for _ in range(field.length or 0)])
        return one

    def _convert(self, name: str, message: Any) -> Any:
        """Return a message of ROS's class for one of ours."""
        made = self._inner(name)()
        for field in self._fields(name):
            setattr(made, field.name, self._value(field, getattr(message, field.name)))
        return made

    def _value(self, field: MessageField, value: Any) -> Any:
        if not (field.many or field.length is not None):
            return self._convert(field.type, value) if "/" in field.type else value
        if "/" in field.type:
            return [self._convert(field.type, each) for each in value]
        return _items(field, value)


_PLAIN: Mapping[str, type] = {"boo": bool, "str": str, "wst": str, "flo": float}
"""Python's type of a plain field, by the first letters of its type."""


def _action_types(name: str) -> dict[str, list[MessageField]]:
    """Return what an action consists of besides its three messages; REP 2011 has the names."""
    uuid = MessageField("goal_id", "unique_identifier_msgs/msg/UUID")
    goal, result, feedback = (f"{name}_{part}" for part in PARTS["action"])
    whole = {
        "goal": goal, "result": result, "feedback": feedback, "send_goal_service": f"{name}_SendGoal",
        "get_result_service": f"{name}_GetResult", "feedback_message": f"{name}_FeedbackMessage",
    }  # fmt: skip
    stamp = MessageField("stamp", "builtin_interfaces/msg/Time")
    return {
        f"{name}_SendGoal_Request": [uuid, MessageField("goal", goal)],
        f"{name}_SendGoal_Response": [MessageField("accepted", "bool"), stamp],
        f"{name}_GetResult_Request": [uuid],
        f"{name}_GetResult_Response": [MessageField("status", "int8"), MessageField("result", result)],
        f"{name}_FeedbackMessage": [uuid, MessageField("feedback", feedback)],
        name: [MessageField(part, kind) for part, kind in whole.items()],
    }


def _items(field: MessageField, values: Any) -> Any:
    """Return the items of a field as ROS has them: of NumPy if their number is fixed, else of ``array``."""
    if field.type in ("bool", "string", "wstring") or "/" in field.type:
        return list(values)
    dtype = np.dtype({"byte": "uint8", "char": "uint8"}.get(field.type, field.type))
    numbers = np.asarray(values, dtype).reshape(-1)
    return numbers if field.length is not None else array(dtype.char, numbers.tobytes())


def _text(field: MessageField) -> str:
    """Return the type of a field as ROS spells it in Python."""
    text = {"float64": "double", "float32": "float", "bool": "boolean"}.get(field.type, field.type)
    text = text.replace("/msg/", "/")
    if field.length is not None:
        return f"{text}[{field.length}]"
    return f"sequence<{text}{f', {field.most}' if field.most else ''}>" if field.many else text


def _initializer(defaults: Mapping[str, Callable[[], Any]]) -> Callable[..., None]:
    """Return the ``__init__`` of a message with these defaults."""

    def initialize(message: Any, **values: Any) -> None:
        if unknown := values.keys() - defaults.keys():
            raise TypeError(f"{type(message).__name__} has no field {', '.join(sorted(unknown))}")
        for name, default in defaults.items():
            setattr(message, name, values[name] if name in values else default())

    return initialize


def _are_equal(one: Any, other: object) -> Any:
    if type(one) is not type(other):
        return NotImplemented
    pairs = ((value, getattr(other, name)) for name, value in vars(one).items())
    return all(
        np.array_equal(*pair) if isinstance(pair[0], np.ndarray) else pair[0] == pair[1] for pair in pairs
    )


def _described(message: Any) -> str:
    cls = type(message)
    values = ", ".join(f"{name}={getattr(message, name)!r}" for name in cls.get_fields_and_field_types())
    return f"{cls.__module__}.{cls.__name__}({values})"


def _class(name: str, content: dict[str, Any], support: dict[str, Any]) -> Any:
    """Return a class whose metaclass has its type support, where ROS looks for it."""
    package, kind, short = name.split("/")
    attributes = {**support, "__import_type_support__": classmethod(lambda _cls: None)}
    meta = type(f"Metaclass_{short}", (type,), attributes)
    return meta(short, (), {"__module__": f"{package}.{kind}", **content})


@cache
def _support() -> TypeSupport:
    import rclpy

    middleware = rclpy.utilities.get_rmw_implementation_identifier()
    if middleware not in MIDDLEWARES:
        raise BackendLoadError(
            f"{middleware} can only use types of installed packages",
            remedy=f"export RMW_IMPLEMENTATION={MIDDLEWARES[0]}",
        )
    try:
        return TypeSupport(_prefixes())
    except (AttributeError, OSError, StopIteration) as error:
        raise BackendLoadError(
            f"types that are not installed need the libraries of ROS 2 Jazzy or later: {error}"
        ) from error


def _installed(package: str, kind: str, short: str) -> Any:
    """Return a class of this ROS; one of ROS 1, or of the platform, which stands in for it, is not meant."""
    before = set(sys.modules)
    try:
        module = import_module(f"{package}.{kind}")
    except ImportError:
        return None
    cls = getattr(module, short, None)
    if hasattr(type(cls), "_TYPE_SUPPORT"):
        return cls
    for name in sys.modules.keys() - before:
        if name.partition(".")[0] == package:
            del sys.modules[name]
    return None


def _prefixes() -> list[Path]:
    """Return the folders of the installation of ROS: those of its set-up script, else that of its wheels."""
    import rclpy

    given = [Path(each) for each in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if each]
    return given or [Path(rclpy.__file__).parents[4]]
