"""The conditions of events, as functions of the time and of past events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from numbers import Real
from operator import attrgetter
from typing import Any

from nrp_core.errors import TopicError
from nrp_core.experiment.events.ground_positions import GroundPositions, Proximity
from nrp_core.experiment.model.event_schema import Event, TopicIs, When
from nrp_core.world.messages.base import type_name
from nrp_core.world.world import World

Times = Mapping[str, int]
"""When each event that has happened did, ns."""

_NUMBER, _TRUTH, _TEXT = "a number", "true or false", "a text"

Condition = Callable[[int, Times], bool]
"""Whether something holds now (ns), given what has happened."""


def trigger(event: Event, world: World, where: GroundPositions) -> Condition:
    """Return what an event waits for.

    Raises:
        TopicError: a condition names a topic or a field that does not exist.
        SceneError: a condition names something that is not in the scene.
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
        proximity, within = Proximity(when.near, world.scene), when.near.within
        conditions.append(lambda _now_ns, _times: proximity.distance(where) <= within)
    if when.topic is not None:
        conditions.append(TopicSays(when.topic, world))
    return lambda now_ns, times: all(holds(now_ns, times) for holds in conditions)


def _has_happened(event: str, after_ns: int, now_ns: int, times: Times) -> bool:
    return event in times and now_ns >= times[event] + after_ns


class TopicSays:
    """Whether a topic says something; as long as it has said nothing, it does not.

    Raises:
        TopicError: there is no such topic, its message has no such field, or what that holds cannot be
            compared with what is wanted.
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
        """What it said last, None for nothing."""
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
    """Return in words what a value can be compared with."""
    if isinstance(value, bool):
        return _TRUTH
    if isinstance(value, Real):
        return _NUMBER
    if isinstance(value, str):
        return _TEXT
    return "a list" if hasattr(value, "__len__") else f"a {type(value).__name__}"
