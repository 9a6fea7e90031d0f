"""Events of a running experiment: each happens once, when its condition holds, and publishes messages."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Container, Mapping, Sequence
from functools import partial
from numbers import Real
from operator import attrgetter
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from nrp_core.errors import TopicError, did_you_mean
from nrp_core.experiment.events.between_steps import LastMessage
from nrp_core.experiment.events.ground_positions import GroundPositions, Proximity, require_poses
from nrp_core.experiment.model.event_schema import Event, Publish, TopicIs, When
from nrp_core.messages.base import type_name
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.materials import color_of
from nrp_core.world.topics import TopicInfo, check_message
from nrp_core.world.world import World

Times = Mapping[str, int]
"""Times of past events, ns."""

_NUMBER, _TRUTH, _TEXT = "a number", "true or false", "a text"

Condition = Callable[[int, Times], bool]
"""Returns whether a condition holds now (ns), given the past events."""


def trigger(event: Event, world: World, where: GroundPositions) -> Condition:
    """Return the condition of an event.

    Raises:
        TopicError: a condition names a topic or a field that does not exist.
        SceneError: a condition names an object that is not in the scene.
        CapabilityError: it needs a distance, and the world does not report poses of models.
    """
    if event.when is not None:
        return AllOf(event.when, world, where)
    due_ns = event.at or 0
    return lambda now_ns, _times: now_ns >= due_ns


class AllOf:
    """The conditions of an event, all of which must hold."""

    def __init__(self, when: When, world: World, where: GroundPositions) -> None:
        self._event, self._after_ns, self._where = when.event, when.after, where
        self._near, self._within = None, 0.0
        if when.near is not None:
            require_poses(world)
            self._near, self._within = Proximity(when.near, world.scene), when.near.within
        self._topic = None if when.topic is None else TopicSays(when.topic, world)

    def __call__(self, now_ns: int, times: Times) -> bool:
        return (
            (self._event is None or (self._event in times and now_ns >= times[self._event] + self._after_ns))
            and (self._near is None or self._near.distance(self._where) <= self._within)
            and (self._topic is None or self._topic(now_ns, times))
        )

    @property
    def is_consequence(self) -> bool:
        """Whether it waits for nothing but another event, which it accompanies."""
        return self._near is None and self._topic is None and not self._after_ns

    def news(self) -> Sequence[int]:
        """Return the times of the messages that came since the last call, ns."""
        return () if self._topic is None else self._topic.news()

    def unchanged_ns(self, where: GroundPositions) -> int | None:
        """Return for how long its distance surely keeps on the same side of the limit, ns."""
        if self._near is not None:
            return self._near.unchanged_ns(where)
        return None if self._topic is None else self._topic.unchanged_ns

    def restore(self) -> None:
        """Continue with the last message of a world that was reset or restored."""
        if self._topic is not None:
            self._topic.restore()


class TopicSays:
    """A condition on the last message of a topic at a moment; false before the first message.

    Raises:
        TopicError: there is no such topic, its message does not have the field, or the values cannot be
            compared.

    Attributes:
        value: the value at the last moment that was looked at; None before the first message.
    """

    def __init__(self, wanted: TopicIs, world: World) -> None:
        self._wanted, self._field = wanted, attrgetter(wanted.field)
        subscription = world.subscribe(wanted.name, depth=None)
        self._last = last = LastMessage(subscription)
        self.news, self.restore, self.unchanged_ns = last.news, last.restore, last.unchanged_ns
        self.value: Any = None
        try:
            example = self._field(subscription.topic.type())
        except AttributeError:
            kind = type_name(subscription.topic.type)
            raise TopicError(f"{wanted.name} carries {kind}, which has no field '{wanted.field}'") from None
        _require_comparable(wanted, example)

    def __call__(self, now_ns: int, _times: Times) -> bool:
        stamped = self._last.at(now_ns)
        self.value = value = None if stamped is None else self._field(stamped.message)
        if value is None:
            return False
        above, below, equals = self._wanted.above, self._wanted.below, self._wanted.equals
        return bool(
            (above is None or value > above)
            and (below is None or value < below)
            and (equals is None or value == equals)
        )


def _require_comparable(wanted: TopicIs, example: Any) -> None:
    what = f"'{wanted.field}' of {wanted.name} is {_kind(example)}"
    if (wanted.above is not None or wanted.below is not None) and _kind(example) != _NUMBER:
        raise TopicError(f"'above' and 'below' are for numbers, and {what}")
    if wanted.equals is not None and _kind(wanted.equals) != _kind(example):
        raise TopicError(f"'equals' is {wanted.equals!r}, and {what}")
    if wanted.equals is not None and _kind(example) not in (_NUMBER, _TRUTH, _TEXT):
        raise TopicError(f"'equals' is for numbers, texts, true and false, and {what}")


def _kind(value: Any) -> str:
    """Return a text with the types that a value can be compared with."""
    if isinstance(value, bool):
        return _TRUTH
    if isinstance(value, Real):
        return _NUMBER
    if isinstance(value, str):
        return _TEXT
    return "a list" if hasattr(value, "__len__") else f"a {type(value).__name__}"


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
        message = _convert(topic.type, value)
    except ValueError as error:
        raise TopicError(f"{topic.name} carries {type_name(topic.type)}: {error}") from None
    check_message(topic, message)
    return message


def _convert(wanted: Any, value: Any) -> Any:
    if dataclasses.is_dataclass(wanted) and isinstance(wanted, type):
        return _message(wanted, value)
    if get_origin(wanted) is list:
        (item,) = get_args(wanted)
        return [_convert(item, part) for part in _as_list(value)]
    if get_origin(wanted) is np.ndarray:
        return np.asarray(_as_list(value), get_args(get_args(wanted)[1])[0])
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
    return wanted(**{name: _convert(hints[name], part) for name, part in given.items()})


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


def _as_list(value: Any) -> list[Any]:
    if isinstance(value, (list, tuple)):
        return list(value)
    raise ValueError(f"{value!r} is not a list")


Action = Callable[[], None]
"""An action of an event."""


def action_of(publish: Publish, world: World) -> Action:
    """Return a function that publishes a message.

    Raises:
        TopicError: the topic does not exist, cannot be published on, or the value does not fit it.
    """
    publication = world.advertise(publish.topic)
    message = to_message(publication.topic, publish.value)
    return partial(publication.publish, message)


class Events:
    """The events of a running experiment.

    The time of an event is that of the message or physics step at which its condition holds. Its actions
    follow between two steps of the loop, so that a message published at ``t`` acts from ``t`` on. Events at
    the same time happen in the order in which they were added, but an event that waits for another one comes
    after it.
    """

    def __init__(self) -> None:
        self._all: dict[str, tuple[Condition, Sequence[Action]]] = {}
        self.reset()

    def reset(self) -> None:
        """Reset to time 0, without past events."""
        self._times: dict[str, int] = {}
        self.restore({})

    @property
    def names(self) -> list[str]:
        """Names of all events, in the order in which they were added."""
        return list(self._all)

    @property
    def times(self) -> Times:
        """Times of past events, ns, in order."""
        return self._times

    def restore(self, times: Times) -> None:
        """Restore the state after these events."""
        self._times = dict(times)
        self._waiting = {name: event for name, event in self._all.items() if name not in times}
        for condition in self.waiting:
            condition.restore()

    def add(self, name: str, condition: Condition, actions: Sequence[Action] = ()) -> None:
        """Add an event.

        Args:
            name: its name.
            condition: its condition.
            actions: its actions, in order.
        """
        self._all[name] = self._waiting[name] = condition, actions

    @property
    def waiting(self) -> list[AllOf]:
        """The conditions of events that can happen between two steps of the loop."""
        return [condition for condition, _ in self._waiting.values() if isinstance(condition, AllOf)]

    def fire_due(self, now_ns: int, changed: Container[object] | None = None) -> list[str]:
        """Execute all events that are due at a moment; return their names, in order.

        Args:
            now_ns: the moment.
            changed: between two steps of the loop, the conditions that may have changed.
        """
        fired: list[str] = []
        looked_at = {
            name: holds
            for name, (holds, _) in self._waiting.items()
            if changed is None or holds in changed or (isinstance(holds, AllOf) and holds.is_consequence)
        }
        while due := [
            name for name, holds in looked_at.items() if name in self._waiting and holds(now_ns, self._times)
        ]:
            for name in due:
                _, actions = self._waiting.pop(name)
                self._times[name] = now_ns
                for action in actions:
                    action()
            fired += due
        return fired
