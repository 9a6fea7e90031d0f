"""Sends subscribed topics of a recording to clients, byte for byte as recorded."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field

from nrp_cockpit.streaming.stored import Stored, StoredMessages
from nrp_cockpit.wire.channels import Kind, Sent
from nrp_cockpit.wire.hub import Hub, to_json
from nrp_cockpit.wire.memory import PAST, past_data
from nrp_core.clock import NS_PER_S
from nrp_core.messages.base import Time, type_name
from nrp_core.messages.cdr import Codec
from nrp_core.messages.foxglove_msgs import SceneEntity, SceneEntityDeletion, SceneUpdate
from nrp_core.recording import RecordedTopic, Role
from nrp_core.recording.layout import SCENE

SCENE_TYPE = type_name(SceneUpdate)
"""The type of scenes for viewers; recordings of version 0.1 have another type."""
WINDOW_NS = 4 * NS_PER_S
"""The time before the target of a seek that is sent too, so that plots are not empty."""
_MOST_BYTES = 1_000_000
"""The maximum size of the last seconds of a topic; of more data, only the last message is sent."""
LATEST = (Role.CAMERA, Role.TRANSFORMS, Role.MODELS, Role.MUSCLES)
"""The roles of topics of which only the last message counts."""


@dataclass(slots=True)
class _Past:
    """The history of one entity: the times of changes, and the entity then; None: it was removed."""

    times_ns: list[int] = field(default_factory=list)
    entities: list[SceneEntity | None] = field(default_factory=list)

    def at(self, t_ns: int) -> SceneEntity | None:
        nth = bisect_right(self.times_ns, t_ns)
        return self.entities[nth - 1] if nth else None


class RecordedScenes:
    """Reads the changes of a scene lazily, each once.

    Args:
        messages: of the recording.
    """

    def __init__(self, messages: StoredMessages) -> None:
        self._messages, self._codec = messages, Codec({})
        self._codec.define(SCENE_TYPE, messages.topics[SCENE].definition)
        self._pasts: dict[str, _Past] = {}
        self._first: bytes | None = None
        self._updates, self._until_ns = 0, -1

    def at(self, t_ns: int) -> bytes | None:
        """Return the message that makes any viewer show the scene of a time.

        Until the first change it is the recorded message.
        """
        self._read(t_ns)
        if self._updates < 2:
            return self._first
        entities, deletions = [], []
        for name, past in self._pasts.items():
            entity = past.at(t_ns)
            if entity is None:
                deletions.append(SceneEntityDeletion(Time.from_ns(self._until_ns), id=name))
            else:
                entities.append(entity)
        return bytes(self._codec.encode(SceneUpdate(deletions, entities)))

    def entities(self, t_ns: int) -> list[SceneEntity]:
        """Return the entities that exist at a time."""
        self._read(t_ns)
        found = (past.at(t_ns) for past in self._pasts.values())
        return [entity for entity in found if entity is not None]

    def _read(self, t_ns: int) -> None:
        if t_ns <= self._until_ns:
            return
        for stored in self._messages.between([SCENE], self._until_ns, t_ns):
            self._first = self._first or stored.data
            self._updates += 1
            self._add(stored.t_ns, self._codec.decode(stored.data, SCENE_TYPE))
        self._until_ns = t_ns

    def _add(self, t_ns: int, update: SceneUpdate) -> None:
        for deletion in update.deletions:
            gone = self._pasts if deletion.type == SceneEntityDeletion.ALL else (deletion.id,)
            for name in tuple(gone):
                self._note(name, t_ns, None)
        for entity in update.entities:
            self._note(entity.id, t_ns, entity)

    def _note(self, name: str, t_ns: int, entity: SceneEntity | None) -> None:
        past = self._pasts.setdefault(name, _Past())
        past.times_ns.append(t_ns)
        past.entities.append(entity)


class RecordedStream:
    """The topics of a recording, sent to a hub. All methods belong to the thread of the session.

    Args:
        messages: those of the recording; their topics are advertised immediately.
        hub: receives the messages.
    """

    def __init__(self, messages: StoredMessages, hub: Hub) -> None:
        self._messages, self._hub = messages, hub
        self._joined: dict[str, int] = {}
        self._at_ns = -1
        self._taken = self._spent_ns = 0
        self._topics = {name: topic for name, topic in messages.topics.items() if _is_streamed(topic)}
        self.scenes = RecordedScenes(messages) if SCENE in self._topics else None
        hub.offer_json(PAST, Kind.EVERY)
        for topic in self._topics.values():
            lost = Kind.LATEST if topic.role in LATEST else Kind.EVERY
            hub.offer(topic.name, topic.type_name, topic.definition, lost)

    @property
    def ms_per_step(self) -> float | None:
        """Mean processor time of this thread for a step, ms; None before the first."""
        return self._spent_ns / self._taken / 1e6 if self._taken else None

    def show(self, t_ns: int) -> None:
        """Send the state at a time, independent of earlier messages."""
        self._hub.forget(self._topics)
        self._joined.clear()
        self._at_ns = t_ns
        self._follow()
        self._hub.flush()

    def take(self, t_ns: int) -> None:
        """Send the new messages since the last call, and the current state to new subscribers."""
        began = time.thread_time_ns()
        self._follow()
        if t_ns > self._at_ns:
            for stored in self._messages.between(self._joined, self._at_ns, t_ns):
                self._send(stored)
            self._at_ns, self._taken = t_ns, self._taken + 1
        self._hub.flush()
        self._spent_ns += time.thread_time_ns() - began

    def _follow(self) -> None:
        """Send the current state of new subscriptions."""
        hub = self._hub
        subscribed = {name: hub.joined[name] for name in hub.subscribed if name in self._topics}
        if subscribed != self._joined:
            before, self._joined = self._joined, subscribed
            hub.forget(before.keys() - subscribed.keys())
            self._show([name for name, joined in subscribed.items() if joined != before.get(name)])

    def _show(self, topics: Iterable[str]) -> None:
        """Send the current state of some topics, and the last seconds of plotted ones."""
        plotted = [name for name in topics if self._topics[name].role not in (*LATEST, Role.SCENE)]
        window: dict[str, list[Stored]] = {name: [] for name in topics}
        from_ns = max(self._at_ns - WINDOW_NS, self._messages.span_ns[0])
        for stored in self._messages.between(plotted, self._at_ns - WINDOW_NS, self._at_ns):
            window[stored.topic].append(stored)
        for name in sorted(window):
            shown = self._shown(self._topics[name], window[name])
            is_cut = name not in plotted or len(shown) < len(window[name])
            self._announce(name, self._at_ns if is_cut else from_ns, len(shown))
            for stored in shown:
                self._send(stored)

    def _announce(self, topic: str, from_ns: int, count: int) -> None:
        about = to_json(past_data(topic, from_ns, count))
        self._hub.send(Sent(self._hub.channels[PAST], self._at_ns, (about,)), keep=False)

    def _shown(self, topic: RecordedTopic, window: list[Stored]) -> list[Stored]:
        """Return the messages to send of a topic: the last seconds if small enough, else the last message."""
        if topic.role == Role.SPIKES:
            return window
        if topic.role == Role.SCENE:
            scene = None if self.scenes is None else self.scenes.at(self._at_ns)
            return [] if scene is None else [Stored(topic.name, self._at_ns, scene)]
        if window:
            return window if sum(len(one.data) for one in window) < _MOST_BYTES else window[-1:]
        last = self._messages.last(topic.name, self._at_ns)
        return [] if last is None else [last]

    def _send(self, stored: Stored) -> None:
        keep = self._topics[stored.topic].role != Role.SPIKES
        channel = self._hub.channels[stored.topic]
        self._hub.send(Sent(channel, stored.t_ns, (stored.data,)), keep=keep)


def _is_streamed(topic: RecordedTopic) -> bool:
    return topic.role != Role.RUN and (topic.name != SCENE or topic.type_name == SCENE_TYPE)
