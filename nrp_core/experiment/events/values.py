"""Messages in the notation of YAML or the command line: a number, a colour, fields by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from nrp_core.errors import TopicError, did_you_mean
from nrp_core.world.messages.base import type_name
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.scene.materials import color_of
from nrp_core.world.topics import TopicInfo, check_message


def to_message(topic: TopicInfo, value: Any) -> Any:
    """Return a message for a topic.

    Args:
        topic: the topic.
        value: a message; or for a message of one field, that field; for a colour its name, that of a
            Gazebo material, or 3 or 4 numbers; for any other the fields by name or in order.

    Raises:
        TopicError: it does not fit the topic.
    """
    try:
        message = _converted(topic.type, value)
    except ValueError as error:
        raise TopicError(f"{topic.name} carries {type_name(topic.type)}: {error}") from None
    check_message(topic, message)
    return message


def _converted(wanted: Any, value: Any) -> Any:
    if dataclasses.is_dataclass(wanted) and isinstance(wanted, type):
        return _message(wanted, value)
    if get_origin(wanted) is list:
        (item,) = get_args(wanted)
        return [_converted(item, part) for part in _listed(value)]
    if get_origin(wanted) is np.ndarray:
        return np.asarray(_listed(value), get_args(get_args(wanted)[1])[0])
    if wanted is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if (
        isinstance(wanted, type)
        and type(value) is not wanted
        and not (wanted is str and isinstance(value, str))
    ):
        raise ValueError(f"{value!r} is not of type {wanted.__name__}")
    return value


def _message(wanted: type, value: Any) -> Any:
    if type_name(type(value)) == type_name(wanted):
        return value
    if wanted is ColorRGBA and isinstance(value, str):
        return ColorRGBA(*color_of(value))
    if wanted is ColorRGBA and isinstance(value, (list, tuple)) and len(value) < 3:
        raise ValueError(f"a colour is [r, g, b] or [r, g, b, a], not {value!r}")
    names = [field.name for field in dataclasses.fields(wanted)]
    given = _by_name(value, names)
    for name in given:
        if name not in names:
            raise ValueError(f"no field '{name}'{did_you_mean(str(name), names)}")
    hints = get_type_hints(wanted)
    return wanted(**{name: _converted(hints[name], part) for name, part in given.items()})


def _by_name(value: Any, names: list[str]) -> dict[str, Any]:
    """Return the fields that a value gives to a message of these: by name, in order, or the only one."""
    if isinstance(value, Mapping):
        return dict(value)
    if len(names) == 1:
        return {names[0]: value}
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{value!r} is not a message; give its fields {', '.join(names)}")
    if len(value) > len(names):
        raise ValueError(f"{len(value)} values for the {len(names)} fields {', '.join(names)}")
    return dict(zip(names, value, strict=False))


def _listed(value: Any) -> list[Any]:
    if isinstance(value, (list, tuple)):
        return list(value)
    raise ValueError(f"{value!r} is not a list")
