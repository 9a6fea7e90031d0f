"""Events of a running experiment: each happens once, when its condition holds, and publishes messages."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from nrp_core.errors import TopicError, did_you_mean
from nrp_core.experiment.events.lanes import ALONE, NEVER, Lane, LaneKind
from nrp_core.experiment.events.sentences import near_sentence, observed_sentence, topic_sentence
from nrp_core.experiment.model.event_schema import Event, Publish, When
from nrp_core.experiment.model.section import Place
from nrp_core.messages.base import type_name
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.observables.condition import Sentence
from nrp_core.observables.observable import Surroundings
from nrp_core.scene.materials import color_of
from nrp_core.scene.model import Scene
from nrp_core.scene.scoped_names import find_joint, find_link, split_name
from nrp_core.world.topics import TopicInfo, check_message
from nrp_core.world.world import World

Times = Mapping[str, int]
"""Times of past events, ns."""

Condition = Callable[[int, Times], bool]
"""Returns whether a condition holds now (ns), given the past events."""


def trigger(event: Event, around: Surroundings) -> Condition:
    """Return the condition of an event.

    Raises:
        TopicError: a condition names a topic or a field that does not exist.
        SceneError: a condition names an object that is not in the scene.
        CapabilityError: the world does not report data that it needs, such as poses of models.
        ExperimentError: its observable does not exist.
    """
    if event.when is not None:
        return AllOf(event.when, around)
    return At(event.at or 0)


@dataclasses.dataclass(frozen=True, slots=True)
class At:
    """The condition of an event at a time, ns."""

    due_ns: int

    def __call__(self, now_ns: int, times: Times) -> bool:
        return now_ns >= self.due_ns


class AllOf:
    """The conditions of an event, all of which must hold."""

    def __init__(self, when: When, around: Surroundings) -> None:
        self._event, self._after_ns = when.event, when.after
        self._waits = self._event is not None  # for another event, so that nothing else matters yet
        self._sentences: list[Sentence] = []
        if when.near is not None:
            self._sentences.append(near_sentence(when.near, around))
        if when.topic is not None:
            self._sentences.append(topic_sentence(when.topic, around))
        if when.observable is not None:
            self._sentences.append(observed_sentence(when, around))
        self.hears = any(sentence.hears for sentence in self._sentences)

    @property
    def sentence(self) -> Sentence | None:
        """Its only observable with a condition, if it is one of positions."""
        return self._sentences[0] if len(self._sentences) == 1 and not self.hears else None

    def lane(self, now_ns: int, times: Times) -> Lane:
        """Return its present state for arrays; see :class:`Lane`."""
        if self._event is not None:
            if self._event not in times:
                return Lane(NEVER)
            begins_ns = times[self._event] + self._after_ns
            if now_ns < begins_ns:
                return Lane(begins_ns)
        return ALONE if self.sentence is None else Lane(NEVER, is_open=True)

    def __call__(self, now_ns: int, times: Times) -> bool:
        self._waits = self._event is not None and self._event not in times
        if self._waits or (self._event is not None and now_ns < times[self._event] + self._after_ns):
            return False
        return all(sentence.holds(now_ns) for sentence in self._sentences)

    @property
    def is_consequence(self) -> bool:
        """Whether it waits for nothing but another event, which it accompanies."""
        return not self._sentences and not self._after_ns

    def news(self) -> Sequence[int]:
        """Return the times of the messages that came since the last call, ns."""
        return [t_ns for sentence in self._sentences for t_ns in sentence.news()]

    def unchanged_ns(self, now_ns: int) -> int | None:
        """Return the time for which its conditions cannot change, ns."""
        if self._waits:
            return None
        known = [sentence.unchanged_ns(now_ns) for sentence in self._sentences]
        return min((one for one in known if one is not None), default=None)

    def look(self, now_ns: int) -> None:
        """Keep the values at a physics step between two steps of the loop."""
        for sentence in self._sentences:
            sentence.look(now_ns)

    def save(self) -> Any:
        """Return the state of its observables."""
        return [sentence.observable.save() for sentence in self._sentences]

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, in a world that was reset or restored."""
        for sentence, state in zip(self._sentences, saved, strict=True):
            sentence.observable.restore(state)


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


def action_of(publish: Publish, world: World, place: Place | None = None) -> Action:
    """Return a function that publishes a message.

    With a place in the experiment file, the function raises an :class:`~nrp_core.errors.ExperimentError` if
    the message is a request that the world rejects: the run would not be the one in the file.

    Raises:
        TopicError: the topic does not exist, cannot be published on, or the value does not fit it.
        SceneError: a request names a link or joint that its model does not have.
    """
    publication = world.advertise(publish.topic)
    message = to_message(publication.topic, publish.value)
    if publication.topic.response is None:
        return partial(publication.publish, message)
    _require_parts(message, world.scene)
    if place is None:
        return partial(publication.publish, message)

    def request() -> None:
        publication.publish(message)
        if (why := world.rejection(publication.topic.name)) is not None:
            raise place.error(f"the world rejected a request: {why}")

    return request


def _require_parts(request: Any, scene: Scene) -> None:
    """Require the links and joints that a request names as ``model::link`` of models that exist already."""
    for field in ("body_name", "link_name", "joint_name"):
        name = str(getattr(request, field, ""))
        if split_name(scene.models, name)[0] is not None:
            (find_joint if field == "joint_name" else find_link)(scene.models, name)


class Events:
    """The events of a running experiment.

    The time of an event is that of the message or physics step at which its condition holds. Its actions
    follow between two steps of the loop, so that a message published at ``t`` acts from ``t`` on. Events at
    the same time happen in the order in which they were added, but an event that waits for another one comes
    after it.

    Attributes:
        waiting: the conditions of events that can happen between two steps of the loop.
    """

    def __init__(self) -> None:
        self._all: dict[str, tuple[Condition, Sequence[Action]]] = {}
        self._unspoilt: dict[str, Any] = {}
        self.reset()

    def reset(self) -> None:
        """Reset to time 0, without past events."""
        self._times: dict[str, int] = {}
        self.restore(({}, self._unspoilt))

    @property
    def names(self) -> list[str]:
        """Names of all events, in the order in which they were added."""
        return list(self._all)

    def lane_kinds(self, moving: Sequence[str]) -> list[LaneKind | None]:
        """Return how arrays can evaluate each condition, given the names of the models that move."""
        sentences = [one.sentence if isinstance(one, AllOf) else None for one, _ in self._all.values()]
        return [None if one is None else LaneKind.of(one, moving) for one in sentences]

    def lanes(self, now_ns: int) -> Iterator[tuple[Lane, Sentence | None]]:
        """Yield the present state of each event, and its condition."""
        for name, (condition, _) in self._all.items():
            if name in self._times:
                yield Lane(NEVER), None
            elif isinstance(condition, AllOf):
                yield condition.lane(now_ns, self._times), condition.sentence
            else:
                yield Lane(condition.due_ns) if isinstance(condition, At) else ALONE, None

    @property
    def times(self) -> Times:
        """Times of past events, ns, in order."""
        return self._times

    def save(self) -> Any:
        """Return the past events and the state of the conditions of the others."""
        return dict(self._times), self._states()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, in a world that was reset or restored."""
        times, states = saved
        self._times = dict(times)
        self._waiting = {name: event for name, event in self._all.items() if name not in times}
        self._list_waiting()
        for name, (condition, _) in self._waiting.items():
            if isinstance(condition, AllOf):
                condition.restore(states.get(name, self._unspoilt[name]))

    def _states(self) -> dict[str, Any]:
        return {name: one.save() for name, (one, _) in self._waiting.items() if isinstance(one, AllOf)}

    def add(self, name: str, condition: Condition, actions: Sequence[Action] = ()) -> None:
        """Add an event.

        Args:
            name: its name.
            condition: its condition.
            actions: its actions, in order.
        """
        self._all[name] = self._waiting[name] = condition, actions
        self._list_waiting()
        if isinstance(condition, AllOf):
            self._unspoilt[name] = condition.save()

    def _list_waiting(self) -> None:
        self.waiting = [one for one, _ in self._waiting.values() if isinstance(one, AllOf)]

    def fire_due(self, now_ns: int, changed: Container[object] | None = None) -> list[str]:
        """Execute all events that are due at a moment; return their names, in order.

        Args:
            now_ns: the moment.
            changed: between two steps of the loop, the conditions that may have changed.
        """
        fired: list[str] = []
        looked_at = list(self._waiting)
        if changed is not None:
            conditions = {name: self._waiting[name][0] for name in looked_at}
            looked_at = [
                name
                for name, holds in conditions.items()
                if holds in changed or (isinstance(holds, AllOf) and holds.is_consequence)
            ]
        while True:
            due = []
            for name in looked_at:  # in each step: no comprehension, which is one more call
                event = self._waiting.get(name)
                if event is not None and event[0](now_ns, self._times):
                    due.append(name)
            if not due:
                return fired
            for name in due:
                _, actions = self._waiting.pop(name)
                self._times[name] = now_ns
                for action in actions:
                    action()
            self._list_waiting()
            fired += due
