"""A bag as a body: messages that ROS 1 or 2 recorded arrive at their times, and commands have no effect.

ROS is not needed. Time 0 is the time of the first message of the bag.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from nrp_core.clock import seconds
from nrp_core.errors import BackendLoadError, NrpError, SimulationError, TopicError, did_you_mean
from nrp_core.messages.cdr import Codec
from nrp_core.messages.cv_bridge import CvBridge, CvBridgeError
from nrp_core.messages.generated import made
from nrp_core.messages.sensor_msgs import CompressedImage, Image
from nrp_core.world import Code, Direction, Model, Part, TopicInfo
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.typesys import TypesysError

from nrp_world_ros.engine import RemotePart, RosEngine
from nrp_world_ros.node import Answer, Letter, Node, Publisher
from nrp_world_ros.ros1_encoding import Ros1Codec
from nrp_world_ros.timekeeping import Sent, Timekeeper

_LOGS = ("/rosout", "/rosout_agg", "/parameter_events", "/events/write_split")
"""Topics on which ROS and its recorder report about themselves."""
_COMPRESSED = "/compressed"
"""The end of the topic on which ROS publishes the images of a camera as compressed files."""


class Bag(Node):
    """A bag in place of a ROS node; messages to it have no effect.

    Args:
        path: a ``.bag`` of ROS 1; an ``.mcap``, a ``.db3`` or a folder with ``metadata.yaml`` of ROS 2.

    Attributes:
        topics: the topics whose types are known here and have the same fields in the bag.
        left_out: the types of the other topics.

    Raises:
        BackendLoadError: there is no such bag, it is empty, or it cannot be read.
    """

    tool = "bag"
    returns_errors = False
    reach = "a bag"

    def __init__(self, path: Path) -> None:
        is_first = path.suffix == ".bag"
        super().__init__(Ros1Codec() if is_first else Codec(), depth=None)
        self.path = path
        self.topics: dict[str, TopicInfo] = {}
        self.left_out: dict[str, str] = {}
        self._reader: Any
        try:
            self._reader = Reader1(path) if is_first else Reader2(path)
            self._reader.open()
            for file in filter(Path.is_file, path.iterdir() if path.is_dir() else [path]):
                file.open("rb").close()  # SQLite reads beside Python, and recordings keep what Python opens
            with ExitStack() as failed:
                failed.callback(self._reader.close)
                files = self._reader.storage.storages if path.is_dir() else []
                self._begin_ns, self._duration_ns = self._span(files)
                self._find_topics()
                failed.pop_all()
        except NrpError:
            raise
        except Exception as error:  # the library raises exceptions of any type on a damaged file
            raise BackendLoadError(f"the bag '{path}' cannot be read: {error}") from error
        self._heard: dict[str, set[str]] = {}
        self.rewind()

    def _span(self, files: list[Any]) -> tuple[int, int]:
        """Return the time of the first message, ns, and the duration, ns.

        Args:
            files: the files that ``metadata.yaml`` describes; only their contents determine the times.
        """
        files.sort(key=lambda file: file.metadata.start_time)
        held = {each.topic for file in files for each in file.connections if each.msgcount}
        said = [each for each in self._reader.connections if each.msgcount]
        read = {each.topic for each in said if next(self._reader.messages([each]), None) is not None}
        if files and (wrong := sorted(held.union(each.topic for each in said) - read)):
            raise BackendLoadError(
                f"'{self.path / 'metadata.yaml'}' and the files beside it disagree about {', '.join(wrong)}",
                remedy=f"ros2 bag reindex {self.path}",
            )
        first = next(self._reader.messages(), None)
        if first is None:
            raise BackendLoadError(f"the bag '{self.path}' has no messages")
        end_ns = max((file.metadata.end_time for file in files), default=self._reader.end_time)
        return first[1], max(end_ns - first[1], 1)

    def _find_topics(self) -> None:
        counts = Counter[str]()
        for each in self._reader.connections:
            counts[_absolute(each.topic)] += each.msgcount
        for each in self._reader.connections:
            name, kind = _absolute(each.topic), self._class(each)
            if counts[name] and kind is None:
                self.left_out[name] = _full(each.msgtype)
            elif counts[name] and kind is not None:
                rate_hz = counts[name] / seconds(self._duration_ns)
                self.topics[name] = TopicInfo(name, kind, Direction.OUT, rate_hz, "in the bag")

    def _class(self, connection: Any) -> type | None:
        """Return the class of the messages of a topic; None if it differs from the type in the bag."""
        name, text = _full(connection.msgtype), connection.msgdef.data
        try:
            if text and "IDL: " not in text:
                self.codec.define(name, text)
            kind = made(name)
            return kind if kind is None or self.codec.name(kind) == name else None
        except (TypesysError, TopicError, KeyError):
            return None

    # -- playing

    def rewind(self) -> None:
        """Continue from the beginning."""
        self._t_ns, self.ended = -1, False
        self._coming: Iterator[Any] | None = None

    def play(self, t_ns: int) -> Sent:
        """Put the messages until a time into the inbox, and return their times."""
        coming = self._coming
        if coming is None:
            heard = [each for each in self._reader.connections if _absolute(each.topic) in self._heard]
            begin_ns = self._begin_ns + self._t_ns + 1
            coming = self._coming = self._messages(heard, begin_ns)
            self._next = next(coming, None)
        sent: Sent = {}
        while self._next is not None and (at_ns := self._next[1] - self._begin_ns) <= t_ns:
            connection, _, data = self._next
            source = _absolute(connection.topic)
            for topic in self._heard[source]:
                letter = Letter if topic == source else _Compressed
                self.inbox.add(letter(topic, _full(connection.msgtype), bytes(data), "the bag", self.codec))
                sent.setdefault(topic, []).append(at_ns)
            self._next = next(coming, None)
        self._t_ns = t_ns
        self.ended = t_ns > self._duration_ns
        return sent

    def _messages(self, heard: list[Any], begin_ns: int) -> Iterator[Any]:
        try:
            if heard:
                yield from self._reader.messages(heard, start=begin_ns)
        except Exception as error:
            raise SimulationError(f"the bag '{self.path}' is damaged: {error}") from error

    # -- the interface of a node

    def listen(self, topic: str, cls: type) -> None:
        source, wanted = topic, cls
        if topic not in self.topics and cls is Image:
            source, wanted = topic + _COMPRESSED, CompressedImage
        if source in self.topics:
            kind = self.topics[source].type
            if kind is not wanted:
                names = self.codec.name(kind), self.codec.name(wanted)
                raise TopicError(f"the messages on {source} are {names[0]} in '{self.path}', not {names[1]}")
            self._heard.setdefault(source, set()).add(topic)
            self._coming = None

    def settle(self, timeout_s: float) -> set[str]:
        return set()

    def missing(self, topics: Collection[str]) -> list[str]:
        """Return the given topics that the bag lacks."""
        return sorted(set(topics).difference(*self._heard.values()))

    def publisher(self, topic: str, cls: type, *, latched: bool = False) -> Publisher:
        return _Nowhere()

    def call(self, service: str, request: Any, response: type, timeout_s: float) -> None:
        """A bag does not answer calls."""

    def check(self) -> None:
        """A bag cannot be lost."""

    def close(self) -> None:
        self._reader.close()

    def serve(self, service: str, request: str, response: str, answer: Answer) -> None: ...

    def keep(self, name: str, text: str) -> None: ...

    def peers(self, topic: str) -> int:
        return 0

    def met(self) -> list[str]:
        return []

    def sees(self, topic: str, other: str) -> bool:
        return True


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"


def _full(kind: str) -> str:
    """Return a type as ``package/msg/Type``; early bags of ROS 2 leave out ``msg``."""
    return kind if kind.count("/") == 2 else kind.replace("/", "/msg/")


class _Nowhere:
    """A publisher without subscribers."""

    def peers(self) -> int:
        return 0

    def publish(self, message: Any) -> None: ...


class _Compressed(Letter):
    """An image as a file, received as an image."""

    @property
    def message(self) -> Any:
        small = self.codec.decode(self.data, self.kind)
        try:
            image = CvBridge().cv2_to_imgmsg(CvBridge().compressed_imgmsg_to_cv2(small, "rgb8"), "rgb8")
        except CvBridgeError as error:
            raise TopicError(f"{self.topic} in the bag: {error}") from error
        image.header = small.header
        return image


class _Playback(Timekeeper):
    """The clock of a bag, as fast as the loop requests."""

    _node: Bag

    def start(self, sent: Sent) -> None:
        self._node.rewind()

    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        sent.clear()
        return self._node.play(t_ns)


class BagEngine(RosEngine):
    """A scene whose sensor data come from a bag; topics that do not belong to a model belong to the world.

    Raises:
        BackendLoadError: there is no such bag, or it cannot be read.
    """

    def _join(self) -> tuple[Node, Timekeeper]:
        assert self._options.bag is not None
        self._bag = Bag(self._options.bag)
        self._known: set[str] = set()
        if unknown := sorted(self._bag.left_out.keys() - set(_LOGS)):
            self.warnings.add(Code.NRP282, _left_out(self._bag, unknown), subject=str(self._bag.path))
        return self._bag, _Playback(self._bag, 0.0)

    def _find_models(self) -> None:
        for name, kind in self._where.topics.items():
            self._bag.listen(name, kind)

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        self._known |= {topic.name for part in usual for topic in part.topics}
        parts = super().parts(usual, model)
        models = self.scene.models
        if model is not (models[-1] if models else None):  # the topics of later models are not known yet
            return parts
        others = [topic for topic in self._bag.topics.values() if topic.name not in self._known]
        return [*parts, RemotePart(_Others(others), self)]

    def _meet(self, wanted: set[str]) -> None:
        for topic in self._bag.missing(wanted):
            if topic in self._bag.left_out:
                raise SimulationError(_left_out(self._bag, [topic]))
            near = did_you_mean(topic, self._bag.topics)
            raise SimulationError(f"the bag '{self._bag.path}' has no messages on {topic}{near}")
        if self.scene.models and not self._where.topics.keys() - self._bag.missing(self._where.topics):
            self._warn_of_poses()

    def _do_advance(self, steps: int) -> None:
        super()._do_advance(steps)
        if self._bag.ended:
            self.warnings.add(Code.NRP278, f"the bag '{self._bag.path}' ends before the run", subject="time")

    def _do_reset(self, seed: int) -> None:
        super()._do_reset(seed)
        self._where = self._pose_source(self.scene)

    def _do_close(self) -> None:
        self._bag.close()


def _left_out(bag: Bag, topics: Iterable[str]) -> str:
    text = ", ".join(f"{topic} ({bag.left_out[topic]})" for topic in topics)
    return f"'{bag.path}': left out, because these types are unknown here, or have other fields: {text}"


class _Others(Part):
    """Topics of a bag that no model of the scene has."""

    def __init__(self, topics: Iterable[TopicInfo]) -> None:
        self.topics = tuple(topics)
