"""The signals recorded after each step: one class for each kind."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from typing import Any, NamedTuple

import numpy as np
import xxhash

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import (
    SinkPort,
    SpikeRecorder,
    SpikeRecorderPort,
    StateRecorderPort,
    VoltageRecorder,
)
from nrp_core.brain.devices.sources import SourcePort
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import milliseconds, nanoseconds, seconds
from nrp_core.experiment.model.experiment import RecordingSection, VoltageSection
from nrp_core.messages import nrp_msgs
from nrp_core.messages.foxglove_msgs import SceneUpdate
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.generated import made
from nrp_core.messages.sensor_msgs import CompressedImage, Image
from nrp_core.messages.std_msgs import Float64, Float64MultiArray, String
from nrp_core.network.voltages import VOLTAGE
from nrp_core.recording.images import compress, compressible
from nrp_core.recording.layout import (
    SCENE,
    TRANSFORMS,
    WORLD_FRAME,
    Images,
    Role,
    compressed_topic,
    device_topic,
    hash_topic,
    spikes_topic,
    voltages_topic,
)
from nrp_core.recording.writing import encoding
from nrp_core.recording.writing.encoding import Parts, TransformsEncoder
from nrp_core.recording.writing.frames import Frames, SceneFrames
from nrp_core.recording.writing.scenery import PlacedVisual, scene_update, shown_visuals
from nrp_core.scene.bodies import free_name
from nrp_core.scene.model import Rgba, Scene
from nrp_core.world.model_states import MODEL_STATES
from nrp_core.world.topics import Stamped, TopicInfo
from nrp_core.world.world import World


class RecordEntry(NamedTuple):
    """A message to be recorded.

    Args:
        t_ns: time of the sample, ns.
        topic: its topic.
        kind: its class.
        about: the metadata of the topic, including its role.
        parts: its bytes; if empty, the codec encodes the message.
        message: the message itself, for the codec.
    """

    t_ns: int
    topic: str
    kind: type
    about: Mapping[str, str]
    parts: Parts = ()
    message: Any = None


QUICKLY_ENCODED = (nrp_msgs.Spikes, ModelStates, Image, Float64, Float64MultiArray)
"""The classes of messages that do not pass through the codec."""

Add = Callable[[RecordEntry], None]
"""Stores an entry."""


def about_role(role: Role, **about: str) -> Mapping[str, str]:
    """Return the metadata of a topic."""
    return {"role": role.value, **about}


def about_topic(role: Role, topic: TopicInfo) -> Mapping[str, str]:
    """Return the metadata of a topic of the world: also its unit, and the names of its elements as JSON."""
    about = {"unit": topic.unit, "elements": json.dumps(topic.elements) if topic.elements else ""}
    return about_role(role, **{key: value for key, value in about.items() if value})


class Signal(ABC):
    """A signal that is recorded after each step."""

    @abstractmethod
    def take(self, now_ns: int, add: Add) -> None:
        """Add new data since the last call."""

    def close(self) -> None:
        """End the observation."""


class Scenery(Signal):
    """The visuals of the room and the robots: all of them at the start, then every change."""

    _about = about_role(Role.SCENE)

    def __init__(self, world: World, frames: SceneFrames) -> None:
        self._world, self._frames = world, frames
        self._scene: Scene | None = None
        self._colors: dict[str, Rgba] = {}
        self._shown: dict[str, PlacedVisual] = {}

    def take(self, now_ns: int, add: Add) -> None:
        scene, colors = self._world.scene, self._world.engine.visual_colors
        if scene is self._scene and colors == self._colors:
            return
        self._scene, self._colors = scene, dict(colors)
        before, self._shown = self._shown, shown_visuals(scene, self._frames.now, colors)
        update = scene_update(before, self._shown, now_ns)
        add(RecordEntry(now_ns, SCENE, SceneUpdate, self._about, message=update))


class MovingModels(Signal):
    """States of the movable models, on Gazebo's topic."""

    _about = about_role(Role.MODELS)

    def __init__(self, world: World) -> None:
        self._world = world
        self._scene: Scene | None = None
        self._seen_ns = -1

    def take(self, now_ns: int, add: Add) -> None:
        world = self._world
        if world.scene is not self._scene:
            self._scene = world.scene
            moving = world.scene.models if world.capabilities.poses else ()
            self._names = [model.name for model in moving if not model.static]
            self._encode = encoding.ModelStatesEncoder(self._names)
        if now_ns > self._seen_ns:
            self._seen_ns = now_ns
            motions = [world.model_motion(name) for name in self._names]
            add(RecordEntry(now_ns, MODEL_STATES, ModelStates, self._about, self._encode(motions)))


class TopicMessages(Signal):
    """The messages of one outgoing topic; a value without a rate is recorded once per step.

    Args:
        world: the world of the topic.
        topic: the topic.
        period_ns: time between two steps.
    """

    _role = Role.SENSOR

    def __init__(self, world: World, topic: TopicInfo, period_ns: int) -> None:
        self._world, self._about = world, about_topic(self._role, topic)
        depth = 1 + ceil((topic.rate_hz or 0.0) * seconds(period_ns))
        self._subscription = world.subscribe(topic.name, depth=depth)
        self._seen_ns = -1

    def take(self, now_ns: int, add: Add) -> None:
        if now_ns < self._seen_ns:  # the run, which a viewer watches, has gone back
            self._seen_ns = -1
        for stamped in self._subscription.since(self._seen_ns):
            self._seen_ns = stamped.t_ns
            add(self._entry(self._subscription.topic.name, stamped))
        self._subscription.clear()  # an image that is kept displaces others from the cache

    def _entry(self, topic: str, stamped: Stamped) -> RecordEntry:
        return RecordEntry(stamped.t_ns, topic, type(stamped.message), self._about, message=stamped.message)

    def close(self) -> None:
        self._world.unsubscribe(self._subscription)


class CameraImages(TopicMessages):
    """The images of one camera, compressed if requested and possible."""

    _role = Role.CAMERA

    def __init__(self, world: World, topic: TopicInfo, period_ns: int, images: Images) -> None:
        super().__init__(world, topic, period_ns)
        self._compressed = images is Images.JPEG

    def _entry(self, topic: str, stamped: Stamped) -> RecordEntry:
        image = stamped.message
        if self._compressed and compressible(image):
            small = compress(image)
            return RecordEntry(
                stamped.t_ns, compressed_topic(topic), CompressedImage, self._about, message=small
            )
        return RecordEntry(stamped.t_ns, topic, Image, self._about, encoding.image(image))


class CameraHashes(TopicMessages):
    """A hash of each image of one camera."""

    def _entry(self, topic: str, stamped: Stamped) -> RecordEntry:
        digest = String(xxhash.xxh3_128_hexdigest(np.ascontiguousarray(stamped.message.data).data))
        return RecordEntry(stamped.t_ns, hash_topic(topic), String, self._about, message=digest)


@dataclass(frozen=True, slots=True)
class _Everything(SpikeRecorder):
    """Collects all spikes until they are taken."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> _EverythingPort:
        return _EverythingPort(self.keep_ms, neurons, n_neurons, name)


class _EverythingPort(SpikeRecorderPort):
    passing = True

    def take(self) -> Spikes:
        """Return the spikes since the last call."""
        parts, self._parts = self._parts, []
        return parts[0] if len(parts) == 1 else Spikes.merged(parts)

    def receive(self, spikes: Spikes, until_ms: float) -> None:
        if len(spikes):  # the spikes of all neurons, without a selection
            self._parts.append(spikes)


class PopulationSpikes(Signal):
    """The spikes of all populations, with a topic for each.

    Args:
        brain: the brain.
        excluded: populations without a topic.
    """

    _about = about_role(Role.SPIKES)

    def __init__(self, brain: Brain, excluded: Collection[str] = ()) -> None:
        self._brain = brain
        self._labels = list(brain.network.populations)
        self._is_excluded = [label in excluded for label in self._labels]
        self._topics = [spikes_topic(label) for label in self._labels]
        self._encoders = [encoding.SpikesEncoder(label) for label in self._labels]
        self._offsets = np.array([brain.network.offsets[label] for label in self._labels])
        port = brain.add_sink(_Everything(), np.arange(brain.network.size), name="recording")
        assert isinstance(port, _EverythingPort)
        self._port = port

    def take(self, now_ns: int, add: Add) -> None:
        spikes = self._port.take()
        if not len(spikes):
            return
        owners = self._offsets[1:].searchsorted(spikes.neurons, "right")
        for owner, count in enumerate(np.bincount(owners).tolist()):
            if not count or self._is_excluded[owner]:
                continue
            neurons, times_ms = spikes.neurons, spikes.times_ms
            if count < len(spikes):  # in most steps of most experiments one population has all spikes
                neurons, times_ms = neurons[owners == owner], times_ms[owners == owner]
            parts = self._encoders[owner](now_ns, neurons - self._offsets[owner], times_ms)
            add(RecordEntry(now_ns, self._topics[owner], nrp_msgs.Spikes, self._about, parts))

    def close(self) -> None:
        self._brain.remove(self._port)


@dataclass(frozen=True, slots=True)
class _Samples(VoltageRecorder):
    """Collects all samples until they are taken."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> _SamplesPort:
        return _SamplesPort(self, neurons, n_neurons, name)


class _SamplesPort(StateRecorderPort):
    passing = True

    def drain(self) -> Iterator[tuple[int, FloatArray]]:
        """Yield the times (ns) and voltages of the samples since the last call."""
        parts, self._samples = self._samples, []
        for times_ms, rows in parts:
            yield from zip(nanoseconds(times_ms).tolist(), rows, strict=True)


class MembraneVoltages(Signal):
    """The membrane voltages of cells of a population or view, which must be shown by the brain.

    Args:
        brain: the brain.
        label: name of the population or view.
        section: which cells, and how often.
    """

    def __init__(self, brain: Brain, label: str, section: VoltageSection) -> None:
        neurons = brain.network.neurons(label)
        cells = list(range(len(neurons)) if section.cells is None else section.cells)
        self._brain, self._topic = brain, voltages_topic(label)
        elements = json.dumps([str(cell) for cell in cells])
        self._about = about_role(Role.VOLTAGE, unit="mV", population=label, elements=elements)
        recorder = _Samples(dt=milliseconds(section.interval))
        port = brain.add_sink(recorder, neurons[cells], name=f"recording {label}")
        assert isinstance(port, _SamplesPort)
        self._port, self._has_begun = port, False

    def take(self, now_ns: int, add: Add) -> None:
        samples = list(self._port.drain())
        if not self._has_begun:  # the brain may have got another state since the recorder was added
            samples = [(now_ns, self._brain.read_state(VOLTAGE, self._port.neurons))]
        self._has_begun = True
        for t_ns, values in samples:
            parts = encoding.float64s(np.ascontiguousarray(values, float))
            add(RecordEntry(t_ns, self._topic, Float64MultiArray, self._about, parts))

    def close(self) -> None:
        self._brain.remove(self._port)


def voltages_of(brain: Brain, scope: RecordingSection) -> list[MembraneVoltages]:
    """Return the voltages that are to be recorded; a brain that is played back shows none."""
    if VOLTAGE not in brain.capabilities.state_variables:
        return []
    return [MembraneVoltages(brain, label, section) for label, section in scope.voltages.items()]


class DeviceRecords(Signal):
    """The values of all devices that have one, whenever they change; devices may be added and removed."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self._devices: tuple[SourcePort | SinkPort, ...] = ()
        self._shown: list[_Device] = []

    def take(self, now_ns: int, add: Add) -> None:
        devices = self._brain.devices
        if devices != self._devices:
            self._devices = devices
            self._shown = self._show()
        for device in self._shown:
            value = getattr(device.port, device.quantity)
            last, device.last = device.last, value
            if value is not last and _differ(value, last):
                add(device.entry(now_ns, value))

    def _show(self) -> list[_Device]:
        """Return all devices with a value, each with its own topic."""
        kept = {id(device.port): device for device in self._shown}
        last = {device.topic: device.last for device in self._shown}
        shown: dict[str, _Device] = {}
        for port in self._devices:
            if port.quantity is not None:
                topic = free_name(device_topic(port.name, port.quantity), shown)
                shown[topic] = kept.get(id(port)) or _Device(port, port.quantity, topic, last.get(topic))
        return list(shown.values())


class _Device:
    """A device, its topic, and the last recorded value."""

    def __init__(self, port: SourcePort | SinkPort, quantity: str, topic: str, last: Any) -> None:
        self.port, self.topic, self.quantity = port, topic, quantity
        self._listens = isinstance(port, SinkPort)
        kind = Role.SINK if self._listens else Role.SOURCE
        neurons = str(port.neurons.tolist())
        self.about = about_role(kind, unit=port.unit, device=port.name, neurons=neurons)
        self.last = last

    def entry(self, now_ns: int, value: Any) -> RecordEntry:
        """Return a new value."""
        if self._listens:
            return RecordEntry(now_ns, self.topic, Float64, self.about, encoding.float64(float(value)))
        parts = encoding.float64s(np.atleast_1d(np.asarray(value, float)))
        return RecordEntry(now_ns, self.topic, Float64MultiArray, self.about, parts)


def _differ(value: Any, last: Any) -> bool:
    if isinstance(value, float):  # the common case, and NumPy's comparison is slow
        return bool(value != last)
    return not np.array_equal(value, last)


PERIOD_NS = 40_000_000
"""Minimum simulated time between two messages: 25 Hz is enough for viewers and videos."""


class LinkTransforms(Signal):
    """The poses of all frames that can move."""

    _about = about_role(Role.TRANSFORMS)

    def __init__(self, frames: SceneFrames) -> None:
        self._frames = frames
        self._encoded: Frames | None = None
        self._due_ns = 0
        kind = made("tf2_msgs/msg/TFMessage")
        assert kind is not None
        self._kind = kind

    def take(self, now_ns: int, add: Add) -> None:
        frames = self._frames.now
        if frames is not self._encoded:
            self._encoded, self._due_ns = frames, now_ns
            self._encode = TransformsEncoder(WORLD_FRAME, frames.names)
        if now_ns < self._due_ns or not frames.names:
            return
        self._due_ns = (now_ns // PERIOD_NS + 1) * PERIOD_NS
        add(RecordEntry(now_ns, TRANSFORMS, self._kind, self._about, self._encode(now_ns, frames.poses())))
