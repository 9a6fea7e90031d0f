"""The conditions of events, as functions of the time and of past events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from numbers import Real
from operator import attrgetter
from typing import Any

from nrp_core.errors import TopicError
from nrp_core.experiment.events.ground_positions import GroundPositions, Proximity, require_poses
from nrp_core.experiment.model.event_schema import Event, TopicIs, When
from nrp_core.world.messages.base import type_name
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
        return _all_of(event.when, world, where)
    due_ns = event.at or 0
    return lambda now_ns, _times: now_ns >= due_ns


def _all_of(when: When, world: World, where: GroundPositions) -> Condition:
    conditions: list[Condition] = []
    if when.event is not None:
        conditions.append(partial(_has_happened, when.event, when.after))
    if when.near is not None:
        require_poses(world)
        proximity, within = Proximity(when.near, world.scene), when.near.within
        conditions.append(lambda _now_ns, _times: proximity.distance(where) <= within)
    if when.topic is not None:
        conditions.append(TopicSays(when.topic, world))
    return lambda now_ns, times: all(holds(now_ns, times) for holds in conditions)


def _has_happened(event: str, after_ns: int, now_ns: int, times: Times) -> bool:
    return event in times and now_ns >= times[event] + after_ns


class TopicSays:
    """A condition on the last message of a topic; false before the first message.

    Raises:
        TopicError: there is no such topic, its message does not have the field, or the values cannot be
            compared.
    """

    def __init__(self, wanted: TopicIs, world: World) -> None:
        self._wanted, self._field = wanted, attrgetter(wanted.field)
        self._subscription = world.subscribe(wanted.name)
        try:
            said = self._field(self._subscription.topic.type())
        except AttributeError:
            kind = type_name(self._subscription.topic.type)
            raise TopicError(f"{wanted.name} carries {kind}, which has no field '{wanted.field}'") from None
        _require_comparable(wanted, said)

    @property
    def value(self) -> Any:
        """The last value, None before the first message."""
        stamped = self._subscription.latest
        return None if stamped is None else self._field(stamped.message)

    def __call__(self, _now_ns: int, _times: Times) -> bool:
        value = self.value
        if value is None:
            return False
        above, below, equals = self._wanted.above, self._wanted.below, self._wanted.equals
        return bool(
            (above is None or value > above)
            and (below is None or value < below)
            and (equals is None or value == equals)
        )


def _require_comparable(wanted: TopicIs, said: Any) -> None:
    what = f"'{wanted.field}' of {wanted.name} is {_kind(said)}"
    if (wanted.above is not None or wanted.below is not None) and _kind(said) != _NUMBER:
        raise TopicError(f"'above' and 'below' are for numbers, and {what}")
    if wanted.equals is not None and _kind(wanted.equals) != _kind(said):
        raise TopicError(f"'equals' is {wanted.equals!r}, and {what}")
    if wanted.equals is not None and _kind(said) not in (_NUMBER, _TRUTH, _TEXT):
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
