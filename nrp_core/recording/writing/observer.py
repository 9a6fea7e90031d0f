"""Collect the data of a brain and a world, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from operator import itemgetter
from typing import Any

import numpy as np

from nrp_core.brain.interface import Brain
from nrp_core.errors import TopicError
from nrp_core.findings import Code, Findings
from nrp_core.recording.layout import CALLED, PUBLISHED, Images, Role
from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.recording.writing.hashes import Step, Voltages
from nrp_core.recording.writing.signals import (
    QUICKLY_ENCODED,
    CameraHashes,
    CameraImages,
    DeviceRecords,
    MovingModels,
    PopulationSpikes,
    RecordEntry,
    Scenery,
    Sensor,
    Signal,
    about_role,
)
from nrp_core.recording.writing.transforms import LinkTransforms
from nrp_core.world.messages import nrp_msgs
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.sensor_msgs import Image
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.model_states import MODEL_STATES
from nrp_core.world.topics import Direction, Stamped, TopicInfo
from nrp_core.world.world import World

_PUBLISHED = about_role(Role.PUBLISHED)
_RUN = about_role(Role.RUN)
_t_ns = itemgetter(0)


class Observer:
    """Observes a brain and a world during a run without changing them.

    Sensor topics are collected only if they have other subscribers; the rest costs nothing.

    Args:
        brain, world: the observed sides.
        period_ns: time between two calls of :meth:`step`.
        images: how camera images are kept.
        codec: encodes the messages.

    Attributes:
        warnings: warnings about data that could not be collected.
    """

    def __init__(
        self, brain: Brain, world: World, *, period_ns: int, images: Images, codec: Codec | None = None
    ) -> None:
        self.warnings = Findings()
        self.codec = codec or Codec()
        for kind in QUICKLY_ENCODED:  # set now, because another thread reads them later
            self.codec.name(kind)
        self._brain, self._world = brain, world
        self._period_ns, self._images = period_ns, images
        self._refused: set[str] = set()
        self._published: dict[str, Mapping[str, str]] = {}
        self._pending: list[RecordEntry] = []
        frames = SceneFrames(world)
        self._signals: list[Signal] = [
            Scenery(world, frames), MovingModels(world), LinkTransforms(frames), PopulationSpikes(brain),
            DeviceRecords(brain),
        ]  # fmt: skip
        self._followed = {MODEL_STATES}
        self._voltages = Voltages(brain)
        self._subscribed: frozenset[str] = frozenset()
        world.add_observer(self._note_published)

    def step(self, number: int) -> Step:
        """Return the new data since the last call, in the order of time.

        Args:
            number: the number of the step; 0 is the state before the first step.
        """
        self._follow_new()
        now_ns = self._brain.now_ns
        for signal in self._signals:
            signal.take(now_ns, self._add)
        pending, self._pending = self._pending, []
        pending.sort(key=_t_ns)
        return Step(now_ns, pending, self._voltages.at(number))

    def note_from_outside(self, topic: str, message: Any) -> None:
        """Collect a message from outside the run."""
        header = Header(Time.from_ns(self._world.now_ns))
        try:
            kind, data = self.codec.name(type(message)), self.codec.encode(message)
        except TopicError:
            return  # reported when it is published
        noted = nrp_msgs.Published(header, topic, kind, data)  # type: ignore[arg-type]
        self._add(RecordEntry(self._world.now_ns, PUBLISHED, nrp_msgs.Published, _RUN, message=noted))

    def note_call(self, name: str, data: bytes) -> None:
        """Collect another call from outside the run."""
        header = Header(Time.from_ns(self._world.now_ns))
        noted = nrp_msgs.Called(header, name, np.frombuffer(data, np.uint8))
        self._add(RecordEntry(self._world.now_ns, CALLED, nrp_msgs.Called, _RUN, message=noted))

    def close(self) -> list[RecordEntry]:
        """End the observation; return the data of an unfinished step."""
        self._world.remove_observer(self._note_published)
        for signal in self._signals:
            with suppress(Exception):  # after a failure an engine may raise an error
                signal.take(self._brain.now_ns, self._add)
            signal.close()
        entries, self._pending = self._pending, []
        return sorted(entries, key=_t_ns)

    def _follow_new(self) -> None:
        """Start to collect newly subscribed topics."""
        subscribed = self._world.subscribed
        if subscribed is not self._subscribed:
            for name in sorted(subscribed - self._followed):
                self._follow(self._world.topics[name])
            self._subscribed = self._world.subscribed

    def _follow(self, topic: TopicInfo) -> None:
        """Collect an outgoing topic; published messages are collected anyway."""
        self._followed.add(topic.name)
        if topic.direction is not Direction.OUT:
            return
        if topic.type is not Image:
            self._signals.append(Sensor(self._world, topic, self._period_ns))
        elif self._images is Images.HASH:
            self._signals.append(CameraHashes(self._world, topic, self._period_ns))
        elif self._images is not Images.OFF:
            self._signals.append(CameraImages(self._world, topic, self._period_ns, self._images))

    def _note_published(self, topic: str, stamped: Stamped) -> None:
        message = stamped.message
        data = self._encoded(topic, message)
        if data is not None:
            about = self._about_published(topic)
            self._pending.append(RecordEntry(stamped.t_ns, topic, type(message), about, (data,)))

    def _about_published(self, topic: str) -> Mapping[str, str]:
        if topic not in self._published:
            unit = self._world.topics[topic].unit
            self._published[topic] = about_role(Role.PUBLISHED, unit=unit) if unit else _PUBLISHED
        return self._published[topic]

    def _add(self, entry: RecordEntry) -> None:
        """Store an entry; it is encoded now, because the owner of the message may change it later."""
        if not entry.parts:
            data = self._encoded(entry.topic, entry.message)
            if data is None:
                return
            entry = RecordEntry(entry.t_ns, entry.topic, entry.kind, entry.about, (data,))
        self._pending.append(entry)

    def _encoded(self, topic: str, message: Any) -> memoryview | None:
        """Return a message as bytes; None, with one warning, if it cannot be encoded."""
        if topic in self._refused:
            return None
        try:
            return self.codec.encode(message)
        except TopicError as error:
            self._refused.add(topic)
            self.warnings.add(Code.NRP284, f"{topic} is not recorded: {error.message}", subject=topic)
            return None


def about_run() -> Mapping[str, str]:
    """Return the metadata of the platform's own topics."""
    return _RUN
