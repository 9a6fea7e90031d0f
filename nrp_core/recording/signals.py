"""What is recorded of a run after each step: one small class for each kind of signal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from nrp_core.brain.interface import Brain
from nrp_core.brain.network import FloatArray, IntArray
from nrp_core.brain.sinks import SinkPort, SpikeRecorder, SpikeRecorderPort
from nrp_core.brain.sources import SourcePort
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import seconds
from nrp_core.recording.layout import Pictures, Role, compressed_topic, device_topic, spikes_topic
from nrp_core.recording.pictures import compress, compressible
from nrp_core.world.interface import World
from nrp_core.world.messages import nrp_msgs
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.gazebo_msgs import ModelStates
from nrp_core.world.messages.std_msgs import Float64, Float64MultiArray, Header
from nrp_core.world.parts.model_states import MODEL_STATES, state_messages
from nrp_core.world.topics import Stamped, TopicInfo


class Entry(NamedTuple):
    """A message to be recorded, which nobody changes any more.

    Args:
        t_ns: when it was taken.
        topic: where it goes.
        message: what it is.
        about: what readers are told of the topic, its role among it.
    """

    t_ns: int
    topic: str
    message: Any
    about: Mapping[str, str]


def about_role(role: Role, **about: str) -> Mapping[str, str]:
    """Return what readers are told of a topic."""
    return {"role": role.value, **about}


class Signal(ABC):
    """Something that is recorded after each step."""

    @abstractmethod
    def take(self, now_ns: int) -> Iterator[Entry]:
        """Return what is new since the last call."""

    def close(self) -> None:
        """Leave the run as if nobody had listened."""


class MovingModels(Signal):
    """Where the models are that can move, under Gazebo's topic."""

    _about = about_role(Role.MODELS)

    def __init__(self, world: World) -> None:
        self._world = world
        self._names = [model.name for model in world.scene.models if not model.static]
        self._seen_ns = -1

    def take(self, now_ns: int) -> Iterator[Entry]:
        if now_ns > self._seen_ns:
            self._seen_ns = now_ns
            states = [state_messages(self._world.model_motion(name)) for name in self._names]
            poses, twists = [pose for pose, _ in states], [twist for _, twist in states]
            yield Entry(now_ns, MODEL_STATES, ModelStates(self._names, poses, twists), self._about)


class Sensor(Signal):
    """The messages of one outgoing topic; a value without a rate is noted once a step.

    Args:
        world: whose topic.
        topic: the topic.
        period_ns: time between two steps.
    """

    _about = about_role(Role.SENSOR)

    def __init__(self, world: World, topic: TopicInfo, period_ns: int) -> None:
        self._world = world
        depth = 1 + ceil((topic.rate_hz or 0.0) * seconds(period_ns))
        self._subscription = world.subscribe(topic.name, depth=depth)
        self._seen_ns = -1

    def take(self, now_ns: int) -> Iterator[Entry]:
        for stamped in self._subscription.since(self._seen_ns):
            self._seen_ns = stamped.t_ns
            yield self._entry(self._subscription.topic.name, stamped)

    def _entry(self, topic: str, stamped: Stamped) -> Entry:
        return Entry(stamped.t_ns, topic, stamped.message, self._about)

    def close(self) -> None:
        self._world.unsubscribe(self._subscription)


class Camera(Sensor):
    """The pictures of one camera, compressed where that is wanted and possible."""

    _about = about_role(Role.CAMERA)

    def __init__(self, world: World, topic: TopicInfo, period_ns: int, pictures: Pictures) -> None:
        super().__init__(world, topic, period_ns)
        self._compressed = pictures is Pictures.JPEG

    def _entry(self, topic: str, stamped: Stamped) -> Entry:
        picture = stamped.message
        if self._compressed and compressible(picture):
            return Entry(stamped.t_ns, compressed_topic(topic), compress(picture), self._about)
        return Entry(stamped.t_ns, topic, picture, self._about)


@dataclass(frozen=True, slots=True)
class _Everything(SpikeRecorder):
    """All spikes, until they are taken."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> _EverythingPort:
        return _EverythingPort(self.keep_ms, neurons, n_neurons, name)


class _EverythingPort(SpikeRecorderPort):
    def take(self) -> Spikes:
        """Return the spikes since the last call."""
        parts, self._parts = self._parts, []
        return parts[0] if len(parts) == 1 else Spikes.merged(parts)


class PopulationSpikes(Signal):
    """The spikes of all populations, a topic each."""

    _about = about_role(Role.SPIKES)

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self._labels = list(brain.network.populations)
        self._offsets = np.array([brain.network.offsets[label] for label in self._labels])
        port = brain.add_sink(_Everything(), np.arange(brain.network.size), name="recording")
        assert isinstance(port, _EverythingPort)
        self._port = port

    def take(self, now_ns: int) -> Iterator[Entry]:
        spikes = self._port.take()
        if not len(spikes):
            return
        if len(self._labels) == 1:
            yield self._entry(now_ns, 0, spikes.neurons, spikes.times_ms)
            return
        owners = np.searchsorted(self._offsets, spikes.neurons, side="right") - 1
        for owner in dict.fromkeys(owners.tolist()):
            chosen = owners == owner
            ids = spikes.neurons[chosen] - self._offsets[owner]
            yield self._entry(now_ns, owner, ids, spikes.times_ms[chosen])

    def _entry(self, now_ns: int, owner: int, ids: IntArray, times_ms: FloatArray) -> Entry:
        label, header = self._labels[owner], Header(Time.from_ns(now_ns))
        message = nrp_msgs.Spikes(header, label, ids.astype(np.uint32), times_ms * 1e-3)
        return Entry(now_ns, spikes_topic(label), message, self._about)

    def close(self) -> None:
        self._brain.remove(self._port)


class DeviceValues(Signal):
    """The values of all devices that have one, whenever they changed; devices may come and go."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self._devices: tuple[SourcePort | SinkPort, ...] = ()
        self._shown: list[_Device] = []

    def take(self, now_ns: int) -> Iterator[Entry]:
        devices = self._brain.devices
        if devices != self._devices:
            self._devices = devices
            self._shown = self._show()
        for device in self._shown:
            message = device.news()
            if message is not None:
                yield Entry(now_ns, device.topic, message, device.about)

    def _show(self) -> list[_Device]:
        """Return all that have a value, each under a topic of its own."""
        kept = {id(device.port): device for device in self._shown}
        shown: dict[str, _Device] = {}
        for port in self._devices:
            if port.quantity is not None:
                topic = _free(device_topic(port.name, port.quantity), shown)
                shown[topic] = kept.get(id(port)) or _Device(port, port.quantity, topic)
        return list(shown.values())


class _Device:
    """A device, its topic, and the value that was recorded last."""

    def __init__(self, port: SourcePort | SinkPort, quantity: str, topic: str) -> None:
        self.port, self.topic, self._quantity = port, topic, quantity
        self._listens = isinstance(port, SinkPort)
        kind = Role.SINK if self._listens else Role.SOURCE
        neurons = str(port.neurons.tolist())
        self.about = about_role(kind, unit=port.unit, device=port.name, neurons=neurons)
        self._last: Any = None

    def news(self) -> Float64 | Float64MultiArray | None:
        """Return the value if it changed since the last call."""
        value = getattr(self.port, self._quantity)
        last, self._last = self._last, value
        if isinstance(value, float):  # the common case, and NumPy's comparison is slow
            if value == last:
                return None
        elif np.array_equal(value, last):
            return None
        if self._listens:
            return Float64(float(value))
        return Float64MultiArray(data=np.atleast_1d(np.asarray(value, float)))


def _free(topic: str, taken: Mapping[str, object]) -> str:
    """Return the topic, with a number behind it where another device has it already."""
    number, free = 1, topic
    while free in taken:
        number += 1
        free = f"{topic}_{number}"
    return free
