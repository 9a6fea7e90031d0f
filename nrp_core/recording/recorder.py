"""Record what goes on between a brain and a world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from operator import itemgetter
from pathlib import Path
from typing import Any

from nrp_core.brain.interface import Brain
from nrp_core.errors import SimulationError, TopicError
from nrp_core.recording.layout import MCAP_NAME, SCENE, Pictures, Role
from nrp_core.recording.scenery import markers
from nrp_core.recording.signals import (
    Camera,
    DeviceValues,
    Entry,
    MovingModels,
    PopulationSpikes,
    Sensor,
    Signal,
    about_role,
)
from nrp_core.recording.writer import McapFile
from nrp_core.world.interface import World
from nrp_core.world.messages.sensor_msgs import Image
from nrp_core.world.parts.model_states import MODEL_STATES
from nrp_core.world.topics import Direction, Stamped, TopicInfo

_PUBLISHED = about_role(Role.PUBLISHED)


class Recorder:
    """Writes what a brain and a world do and exchange into an MCAP file, while they run.

    Of what the world senses, that is recorded which somebody else listens to; the rest costs nothing.
    Memory does not grow with what is recorded. Call :meth:`step` after each step and :meth:`close` at
    the end, however it came about.

    Args:
        brain, world: are listened to from now on.
        directory: an existing folder; ``recording.mcap`` appears in it.
        period_ns: time between two calls of :meth:`step`.
        pictures: how camera pictures are kept.
    """

    def __init__(
        self,
        brain: Brain,
        world: World,
        directory: Path,
        *,
        period_ns: int,
        pictures: Pictures = Pictures.EXACT,
    ) -> None:
        self.warnings: list[str] = []
        self._brain, self._world = brain, world
        self._failed = False
        self._refused: set[str] = set()
        self._pending: list[Entry] = []
        with self._writing():
            self._file = McapFile(directory / MCAP_NAME)
        self._period_ns, self._pictures = period_ns, pictures
        self._signals: list[Signal] = [
            MovingModels(world), PopulationSpikes(brain), DeviceValues(brain)
        ]  # fmt: skip
        self._followed = {MODEL_STATES}
        self._pending.append(Entry(world.now_ns, SCENE, markers(world.scene), about_role(Role.SCENE)))
        self._gather()
        self._write()
        world.add_observer(self._note_published)

    def step(self) -> None:
        """Take in what is new; now and then, write it.

        Raises:
            SimulationError: the file cannot be written, e.g. because the disk is full.
        """
        self._gather()
        if self._file.is_due:
            self._write()

    def close(self) -> None:
        """Write whatever can still be had and close the file; calling it again does nothing."""
        if self._file.closed:
            return
        self._world.remove_observer(self._note_published)
        for signal in self._signals:
            with suppress(Exception):  # after a failure an engine may refuse to say
                self._pending += signal.take(self._brain.now_ns)
            signal.close()
        if self._failed:
            with suppress(OSError):  # which was reported when it first came
                self._file.close()
            return
        self._write()
        with self._writing():
            self._file.close()

    def _gather(self) -> None:
        for name in sorted(self._world.subscribed - self._followed):
            self._follow(self._world.topics[name])
        for signal in self._signals:
            self._pending += signal.take(self._brain.now_ns)

    def _follow(self, topic: TopicInfo) -> None:
        """Record a topic that only gives messages; what is published is noted anyway."""
        self._followed.add(topic.name)
        if topic.direction is not Direction.OUT:
            return
        if topic.type is not Image:
            self._signals.append(Sensor(self._world, topic, self._period_ns))
        elif self._pictures is not Pictures.OFF:
            self._signals.append(Camera(self._world, topic, self._period_ns, self._pictures))

    def _note_published(self, topic: str, stamped: Stamped) -> None:
        """Encode what was published at once, for its sender may change it later."""
        encoded = self._encoded(topic, stamped.message, _PUBLISHED)
        if encoded is not None:
            self._pending.append(Entry(stamped.t_ns, topic, encoded, _PUBLISHED))

    def _write(self) -> None:
        """Write what is pending, in the order of time.

        Many steps at once: the code of encoder and writer is then warm, which halves the cost.
        """
        pending, self._pending = self._pending, []
        with self._writing():
            for t_ns, topic, message, about in sorted(pending, key=itemgetter(0)):
                known = isinstance(message, memoryview)
                data = message if known else self._encoded(topic, message, about)
                if data is not None:
                    self._file.write(topic, t_ns, data)
            self._file.flush()

    def _encoded(self, topic: str, message: Any, about: Mapping[str, str]) -> memoryview | None:
        """Return a message as bytes and announce its topic; None, and once a warning, if that cannot be."""
        if topic in self._refused:
            return None
        codec = self._file.codec
        try:
            data = codec.encode(message)
            if not self._file.knows(topic):
                self._file.announce(topic, codec.name(type(message)), about)
        except TopicError as error:
            self._refused.add(topic)
            self.warnings.append(f"{topic} is not recorded: {error.message}")
            return None
        return data

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._failed = True
            raise SimulationError(
                f"the recording cannot be written: {error.strerror or error}", t_ns=self._world.now_ns
            ) from error
