"""Sends topics of a run to clients and has the hub remember them; other topics are not sampled or encoded."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from nrp_cockpit.streaming.weights import Add, ProjectionWeights, synapses_topic, watchable, weights_topic
from nrp_cockpit.wire.channels import Kind, Sent
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.memory import PAST
from nrp_core.brain import SinkPort
from nrp_core.clock import NS_PER_S
from nrp_core.errors import TopicError
from nrp_core.experiment import Run
from nrp_core.messages import nrp_msgs
from nrp_core.messages.cdr import Codec
from nrp_core.messages.foxglove_msgs import SceneUpdate
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.generated import made
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.network.data import Projection
from nrp_core.recording import (
    DeviceRecords,
    LinkTransforms,
    MovingModels,
    MusclePaths,
    PopulationSpikes,
    RecordEntry,
    SceneFrames,
    Scenery,
    Signal,
    TopicMessages,
)
from nrp_core.recording.layout import MUSCLES, SCENE, TRANSFORMS, device_topic, spikes_topic
from nrp_core.world import Muscle, World
from nrp_core.world.model_states import MODEL_STATES
from nrp_core.world.topics import Direction, Stamped, TopicInfo

Open = Callable[[], Signal]

_ALWAYS = ("spikes", "devices", "published", MODEL_STATES)
"""The sources of topics that are remembered from the beginning."""
PERIOD_NS = 40_000_000
"""Simulated time between two messages with the poses of models: 25 Hz."""
_NOW_ONLY = (SCENE, TRANSFORMS)
"""Topics of which the past is not shown."""


class PublishedMessages(Signal):
    """The messages on all topics that functions, events and users publish on.

    Args:
        world: the world of the topics.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._pending: list[tuple[str, Stamped]] = []
        world.add_observer(self._note)

    def take(self, now_ns: int, add: Add) -> None:
        pending, self._pending = self._pending, []
        for topic, stamped in pending:
            add(RecordEntry(stamped.t_ns, topic, type(stamped.message), {}, message=stamped.message))

    def close(self) -> None:
        self._world.remove_observer(self._note)

    def _note(self, topic: str, stamped: Stamped) -> None:
        self._pending.append((topic, stamped))


class Throttled(Signal):
    """Another signal, taken as often as the poses of links.

    Args:
        signal: the signal.
    """

    def __init__(self, signal: Signal) -> None:
        self._signal, self._due_ns = signal, 0

    def take(self, now_ns: int, add: Add) -> None:
        if now_ns >= self._due_ns:
            self._due_ns = (now_ns // PERIOD_NS + 1) * PERIOD_NS
            self._signal.take(now_ns, add)

    def close(self) -> None:
        self._signal.close()


class LiveStream:
    """The topics of a run, sent to a hub step by step. All methods belong to the thread of the run.

    The hub remembers spikes, devices, the poses of models, published messages, the sensors that the run uses
    (of cameras the last image), and each topic that was ever subscribed to. It does so from the beginning, so
    that whoever opens a page late sees what happened.

    Args:
        run: the run; its topics are advertised immediately.
        hub: receives the messages.
    """

    def __init__(self, run: Run, hub: Hub) -> None:
        self._run, self._hub = run, hub
        self._codec = Codec()
        self._openers: dict[str, Open] = {}
        self._sources: dict[str, str] = {}
        self._open: dict[str, Signal] = {}
        self._offered: set[str] = set()  # topics that are there now
        self._subscribed: frozenset[str] | None = None  # those that it follows
        self._kept: set[str] = set()  # topics to be remembered
        self._known: set[str] = set()  # topics that are remembered
        self._images: dict[str, int] = {}  # the topics of cameras, with the time between two images, ns
        self._unseen: dict[str, RecordEntry] = {}  # their last images that nobody has seen
        self._wanted: set[str] = set()  # topics that are sent
        self._joined = 0
        self._steps = self._spent_ns = 0
        self._now_ns = -1
        self._left: set[str] = set()  # topics without subscribers whose last message is that of now
        hub.offer_json(PAST, Kind.EVERY)
        self.offer_all()

    @property
    def ms_per_step(self) -> float | None:
        """Mean additional wall time of a step with subscribers, ms; None before the first."""
        return self._spent_ns / self._steps / 1e6 if self._steps else None

    @property
    def longest_period_ns(self) -> int:
        """The time in which each camera that is sent takes an image."""
        return max(
            (period_ns for topic, period_ns in self._images.items() if topic in self._wanted), default=0
        )

    @property
    def topics(self) -> set[str]:
        """The advertised topics."""
        return set(self._sources)

    def take(self) -> None:
        """Send the new messages since the last call."""
        hub = self._hub
        if self._left and self._run.loop.now_ns != self._now_ns:
            hub.forget(self._left)
            self._left.clear()
        if hub.subscribed is not self._subscribed or hub.joined[SCENE] != self._joined:
            self._follow()
        if self._unseen and hub.listeners:
            self._show_images()
        if self._open:
            began, now_ns = time.perf_counter_ns(), self._run.loop.now_ns
            is_step, self._now_ns = now_ns != self._now_ns, now_ns
            for signal in tuple(self._open.values()):
                signal.take(now_ns, self._send)
            hub.flush()
            if is_step and now_ns > 0:
                self._steps += 1
                self._spent_ns += time.perf_counter_ns() - began

    def reset(self, *, is_elsewhere: bool = False) -> None:
        """Forget all that is later than now, because the time of the run has jumped.

        Args:
            is_elsewhere: whether its past is another one from now on.
        """
        self._close_all()
        self._show_images()
        self._hub.forget(self._sources)
        if is_elsewhere:
            self._known.clear()
        else:
            # at its start the run has published nothing: what is there was sent by hand, in another life
            self._hub.go_back(self._run.loop.now_ns or -1)
        self._left.clear()
        self.offer_all()
        self._follow()

    def take_poses_again(self) -> None:
        """Send the poses again with the next :meth:`take`, because bodies were moved between two steps."""
        for name in (TRANSFORMS, MODEL_STATES):
            if name in self._open:
                self._open.pop(name).close()
                self._open[name] = self._openers[name]()

    def close(self) -> None:
        """End all observation, and clear the record of sent messages."""
        self._close_all()
        self._hub.forget(self._sources)
        self._hub.forget_past(self._known)
        for each in (self._known, self._left, self._unseen):
            each.clear()

    # -- subscriptions

    def _follow(self) -> None:
        """Open topics that are now subscribed to or kept, and close all others."""
        hub = self._hub
        joined, self._joined, self._subscribed = self._joined, hub.joined[SCENE], hub.subscribed
        subscribed = {topic for topic in hub.subscribed if topic in self._sources}
        self._kept |= subscribed.difference(_NOW_ONLY)
        self._wanted = subscribed | self._kept
        self._remember(self._wanted.difference(_NOW_ONLY))
        wanted = {self._sources[topic] for topic in self._wanted}
        for name in self._open.keys() - wanted:
            self._open.pop(name).close()
            # whoever returns before the next step gets the last ones: a sensor has none in between
            self._left.update(topic for topic, source in self._sources.items() if source == name)
        if joined != self._joined and SCENE in self._open:
            self._open.pop(SCENE).close()  # new subscribers get the complete state, not the last change
        for name in sorted(wanted - self._open.keys()):
            self._open[name] = self._openers[name]()
        self._left = {topic for topic in self._left if self._sources[topic] not in self._open}

    def _remember(self, topics: set[str]) -> None:
        new, now_ns = topics - self._known, self._run.loop.now_ns
        self._known |= new
        if images := new & self._images.keys():
            self._hub.remember(images, now_ns, most=1)
        if others := new - self._images.keys():
            self._hub.remember(others, now_ns)

    def _close_all(self) -> None:
        while self._open:
            self._open.popitem()[1].close()

    def _send(self, entry: RecordEntry) -> None:
        if entry.topic not in self._wanted:
            return
        if entry.topic in self._images:
            if not self._hub.listeners:
                self._unseen[entry.topic] = entry  # drawing and encoding it takes longer than many a step
                return
            self._unseen.pop(entry.topic, None)
        self._encode(entry)

    def _encode(self, entry: RecordEntry) -> None:
        try:
            pieces = tuple(map(bytes, entry.parts)) or (self._codec.encode(entry.message),)
        except TopicError:
            return  # a type of the user's own that ROS 2 cannot carry; recordings report it
        channel = self._hub.channels[entry.topic]
        keep = entry.topic != SCENE and entry.kind is not nrp_msgs.Spikes  # new subscribers get all
        self._hub.send(Sent(channel, entry.t_ns, pieces), keep=keep)

    def _show_images(self) -> None:
        """Send the last images that were taken while nobody was there."""
        unseen, self._unseen = self._unseen, {}
        for entry in unseen.values():
            self._encode(entry)

    # -- advertised topics

    def offer_all(self) -> None:
        """Advertise all present topics, which functions and users add and remove, and withdraw all others."""
        self._offered.clear()
        world, brain = self._run.world, self._run.brain
        frames = SceneFrames(world)
        transforms = made("tf2_msgs/msg/TFMessage")
        assert transforms is not None
        self._offer(SCENE, SceneUpdate, SCENE, lambda: Scenery(world, frames))
        self._offer(TRANSFORMS, transforms, TRANSFORMS, lambda: LinkTransforms(frames), Kind.LATEST)
        if _has_muscles(world):
            self._offer(MUSCLES, SceneUpdate, MUSCLES, lambda: MusclePaths(world), Kind.LATEST)
        self._offer(
            MODEL_STATES, ModelStates, MODEL_STATES, lambda: Throttled(MovingModels(world)), Kind.LATEST
        )
        for label in brain.network.populations:
            self._offer(spikes_topic(label), nrp_msgs.Spikes, "spikes", lambda: PopulationSpikes(brain))
        for topic, kind in self._devices():
            self._offer(topic, kind, "devices", lambda: DeviceRecords(brain))
        for projection in watchable(brain.network):
            self._offer_weights(projection)
        for each in world.topics.values():
            if each.response is None:
                self._offer_topic(each)
        self._withdraw(self._sources.keys() - self._offered)
        self._subscribed = None  # some of them may be kept

    def _offer_weights(self, projection: Projection) -> None:
        brain, topic = self._run.brain, weights_topic(projection.label)
        self._offer(topic, Float64MultiArray, topic, lambda: ProjectionWeights(brain, projection))
        if projection.rewiring is None:
            self._offer(synapses_topic(projection.label), Float64MultiArray, topic, self._openers[topic])

    def _devices(self) -> Iterator[tuple[str, type]]:
        for port in self._run.brain.devices:
            if port.quantity is not None:
                kind = Float64 if isinstance(port, SinkPort) else Float64MultiArray
                yield device_topic(port.name, port.quantity), kind

    def _offer_topic(self, topic: TopicInfo) -> None:
        world, period_ns = self._run.world, self._run.experiment.timestep
        if topic.direction is Direction.IN:
            self._offer(topic.name, topic.type, "published", lambda: PublishedMessages(world))
        elif topic.type is Image:
            self._offer_messages(topic, Kind.LATEST)
            self._images[topic.name] = round(NS_PER_S / (topic.rate_hz or NS_PER_S / period_ns))
        else:
            self._offer_messages(topic, Kind.EVERY)
        if topic.direction is Direction.OUT and topic.name in world.subscribed & self._sources.keys():
            self._kept.add(topic.name)

    def _offer_messages(self, topic: TopicInfo, lost: Kind) -> None:
        world, period_ns = self._run.world, self._run.experiment.timestep
        opener = lambda: TopicMessages(world, topic, period_ns)  # noqa: E731
        self._offer(topic.name, topic.type, topic.name, opener, lost)

    def _offer(self, topic: str, kind: type, source: str, opener: Open, lost: Kind = Kind.EVERY) -> None:
        """Advertise a topic, unless ROS 2 cannot carry its type."""
        self._offered.add(topic)
        if topic in self._sources:
            return
        try:
            name = self._codec.name(kind)
            schema = self._codec.definition(name)
        except TopicError:
            return
        self._hub.offer(topic, name, schema, lost)
        self._sources[topic] = source
        if source in _ALWAYS:
            self._kept.add(topic)
        self._openers.setdefault(source, opener)

    def _withdraw(self, topics: set[str]) -> None:
        if not topics:
            return
        for topic in topics:
            del self._sources[topic]
            self._images.pop(topic, None)
            self._unseen.pop(topic, None)
        for each in (self._kept, self._known, self._wanted, self._left):
            each -= topics
        self._hub.withdraw(topics)


def _has_muscles(world: World) -> bool:
    """Return whether the scene has a muscle with a path."""
    drives = (drive for model in world.scene.models for drive in model.drives)
    return any(isinstance(drive, Muscle) and len(drive.path) > 1 for drive in drives)
