"""Read recordings, including incomplete ones."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Message

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.overview import Overview, Row
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import ExperimentError, did_you_mean, hint_if_close
from nrp_core.messages.cdr import Codec
from nrp_core.paths import path_of
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, STEPS, Role, device_group
from nrp_core.recording.reading.integrity import IntegrityCheck, check_folder_of, check_messages
from nrp_core.recording.reading.mcap_messages import McapMessages, RecordedTopic, is_mcap
from nrp_core.recording.reading.tables import (
    dataset_of,
    events_of,
    frame_of,
    joined_frames,
    library,
    segment_of,
)
from nrp_core.recording.sealing import read_sealed

MCAP_SUFFIX = ".mcap"
"""The intact part of a file with this name is read, even if it is empty."""

_logger = logging.getLogger(__name__)
_OWN = STEPS.rpartition("/")[0]
"""The namespace of the platform's own topics."""
_NOT_TABLES = (Role.CAMERA, Role.SPIKES, Role.SCENE, Role.MUSCLES, Role.RUN)


@dataclass(frozen=True, slots=True)
class Recorded:
    """A message of a recording: topic, simulated time, and the message itself."""

    topic: str
    t_ns: int
    message: Any


class RecordingReader(Overview):
    """A recording on disk.

    Args:
        path: the folder of a recording, or a single MCAP file. A folder that lost its messages can be
            checked, not read.

    Raises:
        ExperimentError: not a recording, or in another format.
    """

    def __init__(self, path: Path | str) -> None:
        path = path_of(path)
        self._has_folder = path.is_dir() or (path.name == MCAP_NAME and (path.parent / RUN_NAME).is_file())
        self.folder = path if path.is_dir() else path.parent
        self.file = path / MCAP_NAME if path.is_dir() else path
        if not path.is_dir() and not self.file.is_file():
            beside = (file.parent.name for file in path.parent.glob(f"*/{MCAP_NAME}"))
            hint = hint_if_close(path.name, beside)
            raise ExperimentError(f"no recording: the folder does not exist{hint}", path=path)
        if not self.file.is_file() and not (path / RUN_NAME).is_file():
            raise self._without_messages()
        if not self._has_folder and self.file.suffix != MCAP_SUFFIX and not is_mcap(self.file):
            raise ExperimentError(
                f"not a recording, which is a folder with a file '{MCAP_NAME}', or such a file", path=path
            )

    def _overview(self) -> tuple[str, Iterable[Row]]:
        return f"in {self.folder if self._has_folder else self.file}", self._topic_rows()

    def _topic_rows(self) -> Iterator[Row]:
        yield ("topic", "type", "role")
        for topic in self.topics.values():
            yield (topic.name, topic.type_name, topic.role)

    @cached_property
    def run(self) -> dict[str, Any]:
        """The contents of ``run.json``: versions, seeds, machine, options, result; empty without it."""
        path = self.folder / RUN_NAME
        return read_sealed(path) if path.is_file() else {}

    @cached_property
    def complete(self) -> bool:
        """Whether the file was closed and is not damaged; otherwise its intact part is read.

        The whole file is read to determine this.
        """
        messages = self._open_messages()
        for _ in messages if messages.closed else ():
            pass
        return messages.whole

    def check(self) -> IntegrityCheck:
        """Compare every byte of the recording with the digests that were taken when it was written.

        Unfinished recordings and those of version 0.1 have no digest of their messages: these
        are compared with the hashes of their steps, as far as they go. Nothing is run.
        """
        return check_folder_of(self.folder) if self._has_folder else check_messages(self.file)

    @cached_property
    def topics(self) -> dict[str, RecordedTopic]:
        """Every topic by its name."""
        return {topic.name: topic for topic, _ in self._open_messages()}

    @checks_arguments("roles")
    def with_role(self, *roles: Role) -> list[RecordedTopic]:
        """Return the topics of these roles.

        Raises:
            ExperimentError: the role does not exist.
        """
        for role in roles:
            if role not in [*Role]:
                raise ExperimentError(
                    f"there is no role '{role}'{did_you_mean(str(role), Role)}", path=self.file
                )
        return [topic for topic in self.topics.values() if topic.role in roles]

    @checks_arguments("topics")
    def messages(self, topics: Iterable[str] | None = None) -> Iterator[Recorded]:
        """Return messages in the order of time, in which they were written.

        A topic on which none was recorded is named in a warning of the log.

        Args:
            topics: only these; all by default.

        Raises:
            ExperimentError: the topics are no names, or a message does not have its type, in a file from
                another program.
        """
        if isinstance(topics, str):
            raise ExperimentError(
                f"topics are a set of names such as {{'{topics}'}}, not a text", path=self.file
            )
        wanted = None if topics is None else _names(topics, self.file)
        return self._messages(wanted)

    def _messages(self, wanted: set[str] | None) -> Iterator[Recorded]:
        codec = Codec({})
        for topic, message in self._choose(wanted):
            yield Recorded(topic.name, message.log_time, self.decoded(codec, topic, message.data))

    @checks_arguments("topic")
    def frame(self, topic: str) -> Any:
        """Return the messages of a topic as a pandas DataFrame, a row for each.

        The index ``time_s`` is the simulated time in s. Columns are named by the dotted path of a field, such
        as ``linear.x``; items of arrays by their number, or their name where the message has names, such as
        ``position.left_wheel``. ``attrs["units"]`` has the unit of each column, empty where none is known.

        Args:
            topic: its name; or that of a group of devices, such as ``/brain/devices/turn/rates/*/rate``, with
                a column for each device and a row for each time at which one changed.

        Raises:
            ExperimentError: it has no message, or its messages are images, spikes, or data of the
                platform.
            CapabilityError: pandas is not installed.
        """
        if not isinstance(topic, str):
            raise ExperimentError(
                f"a frame is selected by the name of one topic, not by {topic!r}", path=self.file
            )
        of_group = {name: of[1] for name in self.topics if (of := device_group(name)) and of[0] == topic}
        if of_group:
            frames = {number: self.frame(name) for name, number in of_group.items()}
            return joined_frames(topic, frames)
        if topic not in self.topics:
            message = f"no message was recorded on '{topic}'{did_you_mean(topic, self.topics)}"
            raise ExperimentError(message, path=self.file)
        found = self.topics[topic]
        if found.role in _NOT_TABLES:
            other = "spikes()" if found.role == Role.SPIKES else f"messages({{'{topic}'}})"
            raise ExperimentError(f"{topic} cannot be a table; use {other}", path=self.file)
        return frame_of(found, ((one.t_ns, one.message) for one in self.messages({topic})))

    def to_xarray(self) -> Any:
        """Return the numbers of all topics that are tables as an xarray Dataset, with units.

        The variable ``husky.cmd_vel.linear.x`` is the field ``linear.x`` of ``/husky/cmd_vel`` over the
        simulated time in s; ``attrs`` has its ``units`` and ``topic``. Topics with other times have other
        coordinates. Texts are left out.

        Raises:
            CapabilityError: xarray is not installed.
        """
        library("xarray")
        chosen = {name: topic for name, topic in self.topics.items() if topic.role not in _NOT_TABLES}
        rows: dict[str, list[tuple[int, Any]]] = {name: [] for name in chosen}
        for one in self.messages(chosen):
            rows[one.topic].append((one.t_ns, one.message))
        frames = {name: frame_of(topic, rows[name]) for name, topic in chosen.items()}
        about = {key: self.run[key] for key in ("experiment", "seed") if self.run.get(key) is not None}
        return dataset_of(frames, about)

    def spikes(self) -> Any:
        """Return all spikes as a Neo Segment with a SpikeTrain for each neuron, in ms since the start.

        Each train is annotated with its ``population`` and its ``neuron``, the index in it from 0:
        ``segment.filter(population="retina", objects="SpikeTrain")`` returns those of one population, with
        silent ones.

        Raises:
            CapabilityError: Neo is not installed.
        """
        codec, end_ns, parts = Codec({}), 0, dict[str, list[Any]]()
        for topic, record in self.raw():
            end_ns = max(end_ns, record.log_time)
            if topic.role == Role.SPIKES:
                message = self.decoded(codec, topic, record.data)
                parts.setdefault(message.population, []).append(message)
        spikes = {
            label: (np.concatenate([m.ids for m in of]), np.concatenate([m.times_ms for m in of]))
            for label, of in parts.items()
        }
        known = dict((self.run.get("brain") or {}).get("populations") or {})
        sizes = {label: int(one["size"]) for label, one in known.items()}
        sizes = {label: int(ids.max()) + 1 if len(ids) else 0 for label, (ids, _) in spikes.items()} | sizes
        return segment_of(
            str(self.run.get("experiment") or self.file.name), sizes, spikes, end_ns / NS_PER_MS
        )

    def events(self) -> Any:
        """Return when each event of the experiment happened, as a pandas DataFrame.

        Its index is the name of the event, its column ``time_s`` the simulated time in s, NaN if it did not
        happen.

        Raises:
            ExperimentError: the run did not end, so that its events are not in the recording.
            CapabilityError: pandas is not installed.
        """
        result = self.run.get("result")
        if result is None:
            raise ExperimentError(
                "events are recorded at the end of a run, and this run was killed or continues",
                path=self.folder,
            )
        return events_of(result.get("events") or {})

    def decoded(self, codec: Codec, topic: RecordedTopic, data: bytes) -> Any:
        """Return a message.

        Raises:
            ExperimentError: it does not have its type, in a file from another program.
        """
        self.define(codec, topic)
        try:
            return codec.decode(data, topic.type_name)
        except Exception as error:  # invalid bytes may raise anything
            message = f"a message of {topic.name} ({topic.type_name}) cannot be read: {error}"
            raise ExperimentError(message, path=self.file) from error

    def define(self, codec: Codec, topic: RecordedTopic) -> None:
        """Add the type of a topic to a codec.

        Raises:
            ExperimentError: its definition is not one of ROS 2, in a file from another program.
        """
        try:
            codec.define(topic.type_name, topic.definition)
        except Exception as error:
            message = f"the type of {topic.name} ({topic.type_name}) cannot be read: {error}"
            raise ExperimentError(message, path=self.file) from error

    def _open_messages(self) -> McapMessages:
        if not self.file.is_file():
            raise self._without_messages()
        return McapMessages(self.file)

    def _without_messages(self) -> ExperimentError:
        return ExperimentError(
            f"this is not a recording: it has no file '{self.file.name}'", path=self.folder
        )

    @checks_arguments()
    def raw(self, topics: Iterable[str] | None = None) -> Iterator[tuple[RecordedTopic, Message]]:
        """Return messages undecoded, as records of the file; otherwise as :meth:`messages`."""
        return self._choose(None if topics is None else _names(topics, self.file))

    def _choose(self, wanted: set[str] | None) -> Iterator[tuple[RecordedTopic, Message]]:
        known = set[str]()
        for topic, message in self._open_messages():
            known.add(topic.name)
            if message is not None and (wanted is None or topic.name in wanted):
                yield topic, message
        for name in sorted((wanted or set()) - known):
            if not name.startswith(_OWN):  # not every recording has all of them
                hint = did_you_mean(name, known)
                _logger.warning("%s: no message was recorded on '%s'%s", self.file, name, hint)


def _names(topics: object, file: Path) -> set[str]:
    """Return the names of topics, given as any iterable.

    Raises:
        ExperimentError: they are something else.
    """
    found = set[str]()
    for name in topics if isinstance(topics, Iterable) else [topics]:
        if not isinstance(name, str):
            raise ExperimentError(f"topics are a set of names, not {name!r:.60}", path=file)
        found.add(name)
    return found
