"""Sends subscribed topics of a recording to clients, byte for byte as recorded."""

from __future__ import annotations

import time
from collections.abc import Iterable

from nrp_cockpit.hearing.scenes import SCENE_TYPE, RecordedScenes
from nrp_cockpit.hearing.stored import Stored, StoredMessages
from nrp_cockpit.wire.channels import Kind, Sent
from nrp_cockpit.wire.hub import Hub
from nrp_core.clock import NS_PER_S
from nrp_core.recording.layout import SCENE, Role
from nrp_core.recording.reading.mcap_messages import RecordedTopic

WINDOW_NS = 4 * NS_PER_S
"""The time before the target of a seek that is sent too, so that plots are not empty."""

_MOST_BYTES = 1_000_000
"""The maximum size of the last seconds of a topic; of more data, only the last message is sent."""
_LATEST = (Role.CAMERA, Role.TRANSFORMS, Role.MODELS)
"""The roles of topics of which only the last message counts."""


class RecordedHearing:
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
        self._topics = {name: topic for name, topic in messages.topics.items() if _is_heard(topic)}
        self.scenes = RecordedScenes(messages) if SCENE in self._topics else None
        for topic in self._topics.values():
            lost = Kind.LATEST if topic.role in _LATEST else Kind.EVERY
            hub.offer(topic.name, topic.type_name, topic.definition, lost)

    @property
    def ms_per_step(self) -> float:
        """Mean processor time of this thread for a step, ms."""
        return self._spent_ns / max(1, self._taken) / 1e6

    def show(self, t_ns: int) -> None:
        """Send the state at a time, whatever was sent before."""
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
        """Send the current state of newly subscribed topics."""
        hub = self._hub
        heard = {name: hub.joined[name] for name in hub.heard if name in self._topics}
        if heard != self._joined:
            before, self._joined = self._joined, heard
            hub.forget(before.keys() - heard.keys())
            self._show([name for name, joined in heard.items() if joined != before.get(name)])

    def _show(self, topics: Iterable[str]) -> None:
        """Send the current state of some topics, and the last seconds of plotted ones."""
        plotted = [name for name in topics if self._topics[name].role not in (*_LATEST, Role.SCENE)]
        window: dict[str, list[Stored]] = {name: [] for name in topics}
        for stored in self._messages.between(plotted, self._at_ns - WINDOW_NS, self._at_ns):
            window[stored.topic].append(stored)
        for name in sorted(window):
            for stored in self._shown(self._topics[name], window[name]):
                self._send(stored)

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


def _is_heard(topic: RecordedTopic) -> bool:
    return topic.role != Role.RUN and (topic.name != SCENE or topic.type_name == SCENE_TYPE)
