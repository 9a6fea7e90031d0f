"""Record the data of a brain and a world."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from operator import itemgetter
from pathlib import Path
from threading import Event, Lock, Thread
from typing import Any

import numpy as np

from nrp_core._support.closing import Closing
from nrp_core.brain.interface import Brain
from nrp_core.errors import RecordingError, TopicError
from nrp_core.experiment.model.experiment import RecordingSection
from nrp_core.findings import Code, Findings
from nrp_core.messages import nrp_msgs
from nrp_core.messages.base import Time
from nrp_core.messages.cdr import Codec
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Header
from nrp_core.recording.layout import CALLED, MCAP_NAME, PUBLISHED, SNAPSHOTS, STEPS, Images, Role
from nrp_core.recording.writing import encoding
from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.recording.writing.hashes import Chain, Hasher, Step, Voltages
from nrp_core.recording.writing.muscles import MusclePaths
from nrp_core.recording.writing.signals import (
    QUICKLY_ENCODED,
    CameraHashes,
    CameraImages,
    DeviceRecords,
    LinkTransforms,
    MovingModels,
    PopulationSpikes,
    RecordEntry,
    Scenery,
    Signal,
    TopicMessages,
    about_role,
    about_topic,
    voltages_of,
)
from nrp_core.recording.writing.writer import McapFile
from nrp_core.world.model_states import MODEL_STATES
from nrp_core.world.topics import Direction, Stamped, TopicInfo
from nrp_core.world.world import World

_RUN = about_role(Role.RUN)
_ALL = RecordingSection()
_t_ns = itemgetter(0)


class StepCollector:
    """Collects the data of each step of a brain and a world without changing them.

    Sensor topics are collected only on request or with other subscribers; the rest costs nothing.

    Args:
        brain, world: the observed sides.
        period_ns: time between two calls of :meth:`step`.
        images: how camera images are kept.
        codec: encodes the messages.
        scope: the populations and topics to leave out or to add.

    Attributes:
        warnings: warnings about data that could not be collected.
    """

    def __init__(
        self,
        brain: Brain,
        world: World,
        *,
        period_ns: int,
        images: Images,
        codec: Codec | None = None,
        scope: RecordingSection = _ALL,
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
            Scenery(world, frames), MovingModels(world), LinkTransforms(frames),
            PopulationSpikes(brain, scope.exclude),
            *voltages_of(brain, scope),
            DeviceRecords(brain), MusclePaths(world),
        ]  # fmt: skip
        self._followed = {MODEL_STATES}
        for name in scope.topics:
            self._follow(world.topics[name])
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
            self._signals.append(TopicMessages(self._world, topic, self._period_ns))
        elif self._images is Images.HASH:
            self._signals.append(CameraHashes(self._world, topic, self._period_ns))
        elif self._images is not Images.OFF:
            self._signals.append(CameraImages(self._world, topic, self._period_ns, self._images))

    def _note_published(self, topic: str, stamped: Stamped) -> None:
        message = stamped.message
        data = self._encode(topic, message)
        if data is not None:
            about = self._about_published(topic)
            self._pending.append(RecordEntry(stamped.t_ns, topic, type(message), about, (data,)))

    def _about_published(self, topic: str) -> Mapping[str, str]:
        if topic not in self._published:
            self._published[topic] = about_topic(Role.PUBLISHED, self._world.topics[topic])
        return self._published[topic]

    def _add(self, entry: RecordEntry) -> None:
        """Store an entry; it is encoded now, because the owner of the message may change it later."""
        if not entry.parts:
            data = self._encode(entry.topic, entry.message)
            if data is None:
                return
            entry = RecordEntry(entry.t_ns, entry.topic, entry.kind, entry.about, (data,))
        self._pending.append(entry)

    def _encode(self, topic: str, message: Any) -> memoryview | None:
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


class Ticker(Closing):
    """Calls a function from a separate thread until it is closed.

    Args:
        call: the function; it must not raise exceptions.
        every_s: wall time between two calls, s.
    """

    def __init__(self, call: Callable[[], None], every_s: float) -> None:
        self._stopped = Event()
        self._thread = Thread(target=self._tick, args=(call, every_s), daemon=True)
        self._thread.start()

    def _tick(self, call: Callable[[], None], every_s: float) -> None:
        while not self._stopped.wait(every_s):
            call()

    def close(self) -> None:
        """Stop after the current call; calling it again does nothing."""
        self._stopped.set()
        self._thread.join()


LATE_S, LOOK_S = 0.07, 0.02
"""Wall time after which a separate thread writes the earlier steps during a long one, and the interval of its
checks, s: together less than the tenth of a second of data that a kill may lose."""


class McapRecorder:
    """Writes the data of a brain and a world into an MCAP file during a run.

    Memory does not grow with the recording. The data of a step are written a tenth of a second after its end,
    even during the next step (except in C code that holds the GIL). Call :meth:`step` after each step and
    :meth:`close` at the end, also after an error.

    Args:
        brain, world: the observed sides.
        directory: an existing folder for ``recording.mcap``.
        period_ns: time between two calls of :meth:`step`.
        images: how camera images are kept.
        scope: the populations and topics to leave out or to add.
        chain: the initial chain of hashes; by default a new one.
        steps: number of earlier steps.
        calls: earlier changes of the transfer functions.
    """

    def __init__(
        self,
        brain: Brain,
        world: World,
        directory: Path,
        *,
        period_ns: int,
        images: Images = Images.EXACT,
        scope: RecordingSection = _ALL,
        chain: Chain | None = None,
        steps: int = 0,
        calls: Iterable[nrp_msgs.Called] = (),
    ) -> None:
        self._world, self._failed = world, False
        self._lock, self._unreported = Lock(), list[Exception]()
        self.chain = chain or Chain.begin(brain, world)
        self.steps = self._written = steps
        with self._writing():
            self._file = McapFile(directory / MCAP_NAME)
        self.collector = StepCollector(
            brain, world, period_ns=period_ns, images=images, codec=self._file.codec, scope=scope
        )
        for call in calls:
            self.collector.note_call(call.name, bytes(call.data))
        self._hasher = Hasher()
        self._announce(STEPS, nrp_msgs.StepHash, about_run())
        self._steps: deque[Step | RecordEntry] = deque([self.collector.step(steps)])
        self.flush()
        self._ticker = Ticker(self._flush_late, LOOK_S)

    @property
    def warnings(self) -> Findings:
        """Warnings about data that could not be recorded."""
        return self.collector.warnings

    def step(self) -> None:
        """Collect new data; at intervals, write them to the file.

        Raises:
            RecordingError: the disk is full, and everything so far was recorded; or the file cannot be
                written, and the data since the last flush is lost.
        """
        self.steps += 1
        self._steps.append(self.collector.step(self.steps))
        self._report()
        if self._file.is_due():
            self.flush()

    def add_snapshot(self, data: bytes) -> None:
        """Record the complete state of the run after the last step."""
        now_ns = self._world.now_ns
        parts = encoding.snapshot(now_ns, self.steps, data)
        self._steps.append(RecordEntry(now_ns, SNAPSHOTS, nrp_msgs.Snapshot, about_run(), parts))

    def flush(self) -> None:
        """Hash and compress the data since the last flush, and pass it to the operating system.

        It does this for many steps at once: warm code halves the cost.
        """
        with self._lock, self._writing():
            self._write_steps()
            self._file.flush()
            if self._file.full is not None:
                raise self._file.full

    def _flush_late(self) -> None:
        """Flush during a long step; errors are raised at the next step."""
        if self._steps and not self._failed and self._file.is_due(LATE_S):
            try:
                self.flush()
            except Exception as error:  # noqa: BLE001  no other code reports it, and a step is missing
                self._failed = True
                self._unreported.append(error)

    def _report(self) -> None:
        if self._unreported:
            raise self._unreported.pop()

    def close(self) -> None:
        """Write the remaining data and close the file; calling it again does nothing.

        Raises:
            RecordingError: the file cannot be written.
        """
        if self._file.closed:
            return
        self._ticker.close()
        rest = self.collector.close()
        if self._failed:
            with suppress(OSError):  # which was reported when it occurred
                if self._file.full is not None:
                    self._write_steps()  # into the reserved space
            with suppress(OSError):
                self._file.close()
            self._report()
            return
        with self._writing():
            self._write_steps()
            for entry in rest:  # for an unfinished step
                self._put(entry)
            self._file.close()

    @property
    def digests(self) -> dict[str, str]:
        """The SHA-256 of the file by its name, once it is closed; empty if it could not be written."""
        return {} if self._file.digest is None else {MCAP_NAME: self._file.digest}

    def _write_steps(self) -> None:
        while self._steps:
            step = self._steps.popleft()
            if isinstance(step, RecordEntry):
                self._put(step)
            else:
                self._write_step(step)

    def _write_step(self, step: Step) -> None:
        for entry in step.entries:
            self._put(entry)
        hashes = self._hasher.hashes(step)
        message = encoding.step_hash(step.t_ns, self._written, hashes, self.chain.add(hashes))
        self._file.write(STEPS, step.t_ns, message)
        self._written += 1

    def _put(self, entry: RecordEntry) -> None:
        if not self._file.knows(entry.topic):
            self._announce(entry.topic, entry.kind, entry.about)
        self._file.write(entry.topic, entry.t_ns, entry.parts)

    def _announce(self, topic: str, kind: type, about: Mapping[str, str]) -> None:
        self._file.announce(topic, self._file.codec.name(kind), about)

    @contextmanager
    def _writing(self) -> Iterator[Any]:
        try:
            yield
        except OSError as error:
            self._failed = True
            raise RecordingError(
                f"the recording cannot be written: {error.strerror or error}", t_ns=self._world.now_ns
            ) from error
