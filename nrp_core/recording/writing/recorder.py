"""Record the data of a brain and a world."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Lock
from typing import Any

from nrp_core.brain.interface import Brain
from nrp_core.errors import RecordingError
from nrp_core.findings import Findings
from nrp_core.recording.layout import MCAP_NAME, SNAPSHOTS, STEPS, Images
from nrp_core.recording.writing import encoding
from nrp_core.recording.writing.hashes import Chain, Hasher, Step
from nrp_core.recording.writing.observer import Observer, about_run
from nrp_core.recording.writing.signals import RecordEntry
from nrp_core.recording.writing.ticker import Ticker
from nrp_core.recording.writing.writer import McapFile
from nrp_core.world.messages import nrp_msgs
from nrp_core.world.world import World

LATE_S, LOOK_S = 0.07, 0.02
"""Wall time after which a separate thread writes the earlier steps during a long one, and the interval of its
checks, s: together less than the tenth of a second of data that a kill may lose."""


class Recorder:
    """Writes the data of a brain and a world into an MCAP file during a run.

    Memory does not grow with the recording. The data of a step are written a tenth of a second after its end,
    even during the next step (except in C code that holds the GIL). Call :meth:`step` after each step and
    :meth:`close` at the end, also after an error.

    Args:
        brain, world: the observed sides.
        directory: an existing folder for ``recording.mcap``.
        period_ns: time between two calls of :meth:`step`.
        images: how camera images are kept.
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
        self.observer = Observer(brain, world, period_ns=period_ns, images=images, codec=self._file.codec)
        for call in calls:
            self.observer.note_call(call.name, bytes(call.data))
        self._hasher = Hasher()
        self._announce(STEPS, nrp_msgs.StepHash, about_run())
        self._steps: deque[Step | RecordEntry] = deque([self.observer.step(steps)])
        self.flush()
        self._ticker = Ticker(self._flush_late, LOOK_S)

    @property
    def warnings(self) -> Findings:
        """Warnings about data that could not be recorded."""
        return self.observer.warnings

    def step(self) -> None:
        """Collect new data; at intervals, write them to the file.

        Raises:
            RecordingError: the disk is full, and everything so far was recorded; or the file cannot be
                written, and the data since the last flush is lost.
        """
        self.steps += 1
        self._steps.append(self.observer.step(self.steps))
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
        rest = self.observer.close()
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
