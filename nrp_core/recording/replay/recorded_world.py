"""A recorded body as a world backend: its sensor data are as recorded, for any command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import from_seconds
from nrp_core.errors import CapabilityError, ExperimentError, TopicError
from nrp_core.experiment.making.plan import Plan, Side
from nrp_core.messages.sensor_msgs import CompressedImage, Image
from nrp_core.network.cells import CELLS
from nrp_core.network.changes import ParameterChange
from nrp_core.network.data import Network, Population, Projection
from nrp_core.recording.images import as_it_was, pixels_of
from nrp_core.recording.layout import Role, spikes_topic
from nrp_core.recording.reading.playback import Playback
from nrp_core.recording.recording import Recording
from nrp_core.scene.model import Model, Rgba, Scene
from nrp_core.scene.rigid import BodyPath, BodyVelocity, JointStates, ModelMotion, Pose, ServoTarget, Wrench
from nrp_core.simulation import Determinism
from nrp_core.world.backend import WorldBackend, WorldOptions
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.model_states import MODEL_STATES
from nrp_core.world.part import Part, PartProxy
from nrp_core.world.topics import TopicInfo


class RecordedBrainBackend(BrainBackend):
    """Opens the brain of a recording.

    Args:
        recording: the recording.
        capabilities: the capabilities of the recorded brain.
    """

    def __init__(self, recording: Recording, capabilities: BrainCapabilities) -> None:
        self._recording = recording
        self._capabilities = replace(
            capabilities, determinism=Determinism.BITWISE, state_variables=frozenset(), snapshot=False,
            releases_gil=False,
        )  # fmt: skip

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return self._capabilities

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        return RecordedBrain(self._recording, network, seed, self._capabilities)


class RecordedBrain(Brain):
    """A network in which every neuron fires as recorded, for any input."""

    def __init__(
        self, recording: Recording, network: Network, seed: int, capabilities: BrainCapabilities
    ) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities, identity="recorded")
        self._playback = Playback(recording, {spikes_topic(label) for label in network.populations})
        self._until_ns = 0
        self._weights: dict[str, FloatArray] = {}
        self._playback.until(0)

    def _emits(self, population: Population) -> bool:
        return True  # the spikes of its sources were recorded, too

    def _do_run_until(self, t_ns: int) -> None:
        self._until_ns = t_ns

    def _do_take_spikes(self) -> Spikes:
        messages = [one.message for one in self._playback.until(self._until_ns)]
        return Spikes.merged([
            Spikes(one.ids.astype(np.int64) + self.network.offsets[one.population], one.times_ms)
            for one in messages
        ])  # fmt: skip

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None: ...

    def _do_inject(self, events: SynapticEvents) -> None: ...

    def _do_set_current(self, currents_na: FloatArray) -> None: ...

    def _do_set_parameters(self, change: ParameterChange) -> None: ...

    def _do_set_synapse_parameters(
        self, projection: Projection, values: Mapping[str, FloatArray]
    ) -> None: ...

    def _do_set_plastic(self, projection: Projection, plastic: bool) -> None: ...

    def _do_reward(self, population: str, amount: float) -> None: ...

    def _do_hold_reward(self, population: str, value: float) -> None: ...

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        self._weights[projection.label] = weights

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        if projection.is_plastic:
            raise CapabilityError(
                f"the brain is replayed, and the weights that '{projection.label}' learned were not recorded"
            )
        return self._weights.get(projection.label, projection.weight).copy()

    def _do_read_synapse_state(self, projection: Projection, variable: str) -> FloatArray:
        raise CapabilityError(
            f"the brain is replayed, and the state of synapses of '{projection.label}' was not recorded"
        )

    def _do_reset(self, seed: int) -> None:
        self._until_ns, self._weights = 0, {}
        self._playback.reset()
        self._playback.until(0)

    def _reset_state(self) -> None:
        """Do nothing: its later spikes are recorded, too."""

    def _do_close(self) -> None: ...


def with_recorded_brain(plan: Plan, recording: Recording) -> Plan:
    """Return a plan with a recorded brain.

    Raises:
        ExperimentError: the recording leaves out some of its spikes.
    """
    excluded = recording.run.get("settings", {}).get("recording", {}).get("exclude")
    if excluded:
        left_out = ", ".join(f"'{label}'" for label in excluded)
        raise ExperimentError(
            f"its brain cannot be replayed without the spikes of {left_out}", path=recording.file
        )
    backend = RecordedBrainBackend(recording, plan.brain.capabilities)
    return replace(plan, brain=Side(backend, BrainOptions(), backend.capabilities(BrainOptions())))


def recorded_network(run: Mapping[str, Any]) -> Network | None:
    """Return the populations and named groups of a recording, with PyNN's default parameters and no synapses.

    Args:
        run: the data of ``run.json``.

    Returns:
        None if the recording does not have them all: it is of an earlier version, or has other cells.
    """
    brain = run.get("brain") or {}
    populations = dict(brain.get("populations") or {})
    if "members" not in brain or any(one["cell_type"] not in CELLS for one in populations.values()):
        return None
    views = {name: np.array(ids, np.int64) for name, ids in brain["members"].items()}
    return Network({label: _population(label, **one) for label, one in populations.items()}, views=views)


def _population(label: str, size: int, cell_type: str) -> Population:
    cell = CELLS[cell_type]
    parameters = {name: np.full(size, parameter.default) for name, parameter in cell.parameters.items()}
    values = {name: np.full(size, parameter.default) for name, parameter in cell.state.items()}
    return Population(label, size, cell_type, parameters, values)


_COMPRESSED = "/compressed"


class RecordedWorldBackend(WorldBackend):
    """Opens the world of a recording.

    Args:
        recording: the recording.
        capabilities: the capabilities of the recorded world.
    """

    def __init__(self, recording: Recording, capabilities: WorldCapabilities) -> None:
        self._recording = recording
        self._capabilities = replace(capabilities, determinism=Determinism.BITWISE, snapshot=False)

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        return self._capabilities

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        return RecordedEngine(self._recording, scene, seed, self._capabilities)


class RecordedEngine(Engine):
    """A scene that changes as recorded."""

    def __init__(
        self, recording: Recording, scene: Scene, seed: int, capabilities: WorldCapabilities
    ) -> None:
        topics = [topic.name for topic in recording.with_role(Role.SENSOR, Role.CAMERA)]
        self._recorded_topics = {name.removesuffix(_COMPRESSED): name for name in topics}
        self._recording, self._sensed = recording, dict[str, _Sensed]()
        self._playback = Playback(recording, {MODEL_STATES, *topics})
        self._playback.until(0)
        super().__init__(scene, capabilities, seed=seed, identity="recorded")

    @property
    def title(self) -> str:
        return "the recorded world"

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        return [self._with_recorded(part) for part in usual]

    def _with_recorded(self, part: Part) -> Part:
        recorded = [topic for topic in part.topics if topic.name in self._recorded_topics]
        sensed = {topic.name: self._sensed.get(topic.name) or self._sense(topic) for topic in recorded}
        return _AsRecorded(part, sensed) if sensed else part

    def _sense(self, info: TopicInfo) -> _Sensed:
        recorded_as = self._recorded_topics[info.name]
        if info.delay:
            ahead = Playback(self._recording, {recorded_as})
            sensed: _Sensed = _SensedLate(ahead, recorded_as, info.type, delay_ns=from_seconds(info.delay))
        else:
            sensed = _Sensed(self._playback, recorded_as, recorded_at=info.rate_hz is not None)
        self._sensed[info.name] = sensed
        return sensed

    def _do_advance(self, steps: int) -> None:
        self._playback.until(self.now_ns + steps * self.capabilities.step_ns)

    def _do_reset(self, seed: int) -> None:
        self._playback.reset()
        self._playback.until(0)
        for sensed in self._sensed.values():
            sensed.reset()

    def _do_load(self, scene: Scene) -> None:
        """Models are added and deleted as recorded; they have no behaviour of their own."""

    def _do_configuration(self, model: str) -> None:
        """Return nothing, because models have no state here."""

    def _do_configure(self, model: str, configuration: object) -> None:
        """Do nothing, because models have no state here."""

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        """Return the recorded motion."""

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Return the recorded joint states."""

    def _do_joint_states(self, model: str) -> JointStates:
        """Return no joint, because models have no state here."""
        return JointStates((), *np.empty((3, 0)))

    def _do_model_motion(self, model: str) -> ModelMotion:
        recorded = self._playback.latest.get(MODEL_STATES)
        if recorded is None or model not in recorded.message.name:
            return ModelMotion(self.scene.model(model).pose)
        index = recorded.message.name.index(model)
        pose, twist = recorded.message.pose[index], recorded.message.twist[index]
        p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
        return ModelMotion(Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w)), (v.x, v.y, v.z), (w.x, w.y, w.z))

    def _do_render(self, model: str, link: str, camera: str) -> Any:
        raise CapabilityError(
            f"the recording has no images of {model}/{link}/{camera}: it was made with --images off or "
            "hash, or nothing subscribed to them"
        )

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Do nothing: commands have no effect."""

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        """Do nothing: changes of colours have no effect."""

    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Do nothing: joint commands have no effect."""

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Do nothing: efforts have no effect."""

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Do nothing: wrenches have no effect."""


class _AsRecorded(PartProxy):
    """A part whose topics are read from a recording.

    Args:
        inner: the part.
        sensed: the reader of each recorded topic.
    """

    def __init__(self, inner: Part, sensed: Mapping[str, _Sensed]) -> None:
        super().__init__(inner)
        self._sensed = sensed

    def read(self, topic: str, now_ns: int) -> Any:
        sensed = self._sensed.get(topic)
        return super().read(topic, now_ns) if sensed is None else sensed.read(topic, now_ns)


class _Sensed:
    """Returns the messages of one topic as recorded.

    Args:
        playback: reads the recording.
        topic: the topic in the recording.
        recorded_at: whether there must be a message at exactly this time.
    """

    def __init__(self, playback: Playback, topic: str, *, recorded_at: bool) -> None:
        self._playback, self._topic, self._recorded_at = playback, topic, recorded_at

    def read(self, topic: str, now_ns: int) -> Any:
        recorded = self._playback.latest.get(self._topic)
        if recorded is None or (self._recorded_at and recorded.t_ns != now_ns):
            raise TopicError(f"the recording has no message on {topic} at {now_ns * 1e-9:g} s")
        return _as_from_sensor(recorded.message)

    def reset(self) -> None:
        """Return to the start."""


class _SensedLate(_Sensed):
    """Returns the messages of one topic with a delay from sample to arrival and recording.

    Args:
        ahead: reads the recording of this topic alone.
        topic: the topic in the recording.
        kind: the class of its messages.
        delay_ns: the delay, ns.
    """

    def __init__(self, ahead: Playback, topic: str, kind: type, *, delay_ns: int) -> None:
        super().__init__(ahead, topic, recorded_at=True)
        self._kind, self._delay_ns = kind, delay_ns

    def read(self, topic: str, now_ns: int) -> Any:
        self._playback.until(now_ns + self._delay_ns)
        recorded = self._playback.latest.get(self._topic)
        arrived_at_ns = None if recorded is None else recorded.t_ns
        if arrived_at_ns != now_ns + self._delay_ns and self._playback.ended:
            return self._kind()  # the recorded run ended before it arrived, and so will this one
        return super().read(topic, now_ns + self._delay_ns)

    def reset(self) -> None:
        self._playback.reset()


def _as_from_sensor(message: Any) -> Any:
    """Return a message as from its sensor."""
    if isinstance(message, CompressedImage):
        return _image(message)
    return as_it_was(message) if isinstance(message, Image) else message


def _image(small: CompressedImage) -> Image:
    pixels = pixels_of(small)
    height, width, channels = pixels.shape
    return Image(small.header, height, width, "rgb8", 0, width * channels, pixels)


def with_recorded_world(plan: Plan, recording: Recording) -> Plan:
    """Return a plan with a recorded world."""
    backend = RecordedWorldBackend(recording, plan.world.capabilities)
    return replace(plan, world=Side(backend, WorldOptions(), backend.capabilities(WorldOptions())))
