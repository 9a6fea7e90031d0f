"""Mocks and a test rig for transfer functions, without simulators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import SpikeRecorderPort
from nrp_core.brain.devices.sources import SourcePort
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS, from_seconds, milliseconds
from nrp_core.dsl.calls import ONCE
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource, Variable
from nrp_core.dsl.monitors import MonitoringFunction
from nrp_core.dsl.parameters import ReceivedMessage, SubscribedTopic
from nrp_core.dsl.rewards import MapReward
from nrp_core.dsl.selection import GROUP, Groups, Selection, select, select_projection
from nrp_core.dsl.weights import MapWeights, Weights
from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.network.changes import EQUATIONS, PLASTICITY, WEIGHTS
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import STATIC, STDP
from nrp_core.scene.model import Model, Rgba, Scene
from nrp_core.scene.rigid import (
    BodyPath,
    BodyVelocity,
    JointStates,
    ModelMotion,
    Quaternion,
    ServoTarget,
    Touch,
    Wrench,
)
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.topics import Stamped, TopicInfo, check_message
from nrp_core.world.world import World

_CELL = "MockCell"
_EMPTY = Scene(())
_REST = {"v": -65.0, "gsyn_exc": 0.0, "gsyn_inh": 0.0}


class MockBrain(Brain):
    """Neurons that spike on demand.

    Args:
        populations: size of each population, by name; or a whole network.
        step_ns: its time step; None: any time can be reached.
        releases_gil: the declared capability.
        capabilities: the declared capabilities; by default those that the network needs.

    Attributes:
        values: state of its neurons, by variable, shape ``(network.size,)``.
        rewards: the population and the dopamine of each reward since the beginning or a reset.
        held_rewards: the value that is held now, by population.
        synapse_parameters: changed parameters of synapses in equations, by projection.

    Raises:
        CapabilityError: the given capabilities do not cover the network.
    """

    reads_parameters = False

    def __init__(
        self,
        populations: Mapping[str, int] | Network,
        *,
        step_ns: int | None = None,
        releases_gil: bool = False,
        capabilities: BrainCapabilities | None = None,
    ) -> None:
        if isinstance(populations, Network):
            network = populations
        else:
            network = Network({name: Population(name, n, _CELL, {}) for name, n in populations.items()})
        needed = BrainCapabilities(
            cells=frozenset(population.cell_type for population in network.populations.values()),
            synapses=frozenset(projection.synapse_type for projection in network.projections),
            resolution_ns=step_ns,
            state_variables=frozenset(_REST),
            changes=frozenset({WEIGHTS, PLASTICITY, EQUATIONS}),
            neuromodulation=True,
            rewards=True,
            releases_gil=releases_gil,
        )
        self.values = {name: np.full(network.size, value) for name, value in _REST.items()}
        super().__init__(network, seed=0, capabilities=capabilities or needed, identity="mock")
        others = self.capabilities.state_variables - self.values.keys()
        self.values |= {name: np.zeros(network.size) for name in sorted(others)}
        self._planned: list[Spikes] = []
        self._weights: dict[str, FloatArray] = {}
        self.rewards: list[tuple[str, float]] = []
        self.held_rewards: dict[str, float] = {}
        self.synapse_parameters: dict[str, Mapping[str, FloatArray]] = {}

    def fire(self, neurons: npt.ArrayLike, times_ms: npt.ArrayLike) -> None:
        """Make neurons (global ids) spike at ascending times of the next step."""
        ids, times = np.broadcast_arrays(np.atleast_1d(neurons), np.atleast_1d(times_ms))
        self._planned.append(Spikes(ids.astype(np.int64), times.astype(float)))

    def _do_run_until(self, t_ns: int) -> None: ...

    def _do_take_spikes(self) -> Spikes:
        spikes, self._planned = Spikes.merged(self._planned), []
        return spikes

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None: ...

    def _do_inject(self, events: SynapticEvents) -> None: ...

    def _do_set_current(self, currents_na: FloatArray) -> None: ...

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return self.values[variable][neurons]

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return self._weights.get(projection.label, projection.weight).copy()

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        self._weights[projection.label] = weights

    def _do_reward(self, population: str, amount: float) -> None:
        self.rewards.append((population, amount))

    def _do_hold_reward(self, population: str, value: float) -> None:
        self.held_rewards[population] = value

    def _do_set_plastic(self, projection: Projection, plastic: bool) -> None: ...

    def _do_read_synapse_state(self, projection: Projection, variable: str) -> FloatArray:
        return np.zeros(projection.size)

    def _do_set_synapse_parameters(self, projection: Projection, values: Mapping[str, FloatArray]) -> None:
        before = self.synapse_parameters.get(projection.label, {})
        self.synapse_parameters[projection.label] = {**before, **values}

    def _do_reset(self, seed: int) -> None:
        self._planned, self._weights, self.rewards, self.held_rewards = [], {}, [], {}
        self.synapse_parameters = {}

    def _do_close(self) -> None: ...


class MockPart(Part):
    """A part whose messages are empty, and which does nothing.

    Args:
        topics: its topics.
    """

    def __init__(self, topics: Sequence[TopicInfo]) -> None:
        self.topics = tuple(topics)
        self._types = {topic.name: topic.type for topic in topics}

    def read(self, topic: str, now_ns: int) -> Any:
        return self._types[topic]()

    def write(self, topic: str, message: Any, now_ns: int) -> None: ...


class MockEngine(Engine):
    """An engine whose models never move or touch, without cameras.

    Args:
        scene: the models.
        step_ns: its physics step.
        topics: further topics that the scene does not have; their messages are empty.

    Attributes:
        renderers: the declared capability; a subclass with renderers has cameras.
        own_topics: its own topics.
    """

    renderers: ClassVar[tuple[str, ...]] = ()

    def __init__(
        self, scene: Scene = _EMPTY, *, step_ns: int = NS_PER_MS, topics: Sequence[TopicInfo] = ()
    ) -> None:
        capabilities = WorldCapabilities(
            step_ns,
            renderers=self.renderers,
            links=True,
            contacts=True,
            joint_control=True,
            ball_joints=True,
            ball_control=True,
            coupled_joints=True,
            loops=True,
            own_actuators=True,
            wrapping=True,
            muscles=True,
        )
        super().__init__(scene, capabilities, seed=0, identity="mock")
        self.own_topics = tuple(topics)
        self._own = MockPart(topics)

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        return [*usual, self._own] if model is None else usual

    def _do_advance(self, steps: int) -> None: ...

    def _do_reset(self, seed: int) -> None: ...

    def _do_model_motion(self, model: str) -> ModelMotion:
        return ModelMotion(self.scene.model(model).pose)

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        owner = self.scene.model(model)
        return ModelMotion(owner.pose @ owner.link(link).pose)

    def _do_joint_states(self, model: str) -> JointStates:
        names = tuple(name for joint in self.scene.model(model).joints for name in joint.coordinates)
        return JointStates(names, *np.zeros((3, len(names))))

    def set_control(self, model: str, actuator: str, value: float) -> None: ...

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        return np.zeros((4, len(actuators)))

    def _do_sensor_values(self, model: str, sensor: str) -> FloatArray:
        return np.zeros(1)

    def _do_touches(self) -> Sequence[Touch]:
        return ()

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None: ...

    def _do_set_color(self, visual: str, rgba: Rgba) -> None: ...

    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None: ...

    def _do_set_ball_target(self, model: str, joint: str, orientation: Quaternion | None) -> None: ...

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None: ...

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None: ...


class MockWorld(World):
    """A world without physics: its topics carry only published messages.

    Args:
        topics: message class of each topic, by name.
        scene: models, which never move, with their topics; empty by default.
        step_ns: its physics step.
        engine: replaces the mock engine; it then has the scene and the step.
    """

    def __init__(
        self,
        topics: Mapping[str, type] | None = None,
        *,
        scene: Scene = _EMPTY,
        step_ns: int = NS_PER_MS,
        engine: Engine | None = None,
    ) -> None:
        super().__init__(engine or MockEngine(scene, step_ns=step_ns))
        self._sent: list[tuple[str, Any]] = []
        self.add_observer(lambda topic, stamped: self._sent.append((topic, stamped.message)))
        for name, type_ in (topics or {}).items():
            self.declare(name, type_)

    def put(self, topic: str, message: Any, t_ns: int | None = None) -> None:
        """Publish a message as the robot would, by default at the present time."""
        if t_ns is None:
            self.advertise(topic).publish(message)
        else:
            info = self._board.info(topic)
            check_message(info, message)
            self._board.push(info.name, Stamped(t_ns, message))

    def sent(self, topic: str) -> list[Any]:
        """Return every message on a topic since the last reset, oldest first."""
        name = self._board.info(topic).name
        return [message for sent_on, message in self._sent if sent_on == name]

    def _reset(self) -> None:
        super()._reset()
        self._sent.clear()


_POPULATION_SIZE = 1000


class Rig:
    """A transfer function between a mock brain and a mock world with all its populations and topics.

    Args:
        function: the transfer function; it is bound to the mocks.
        brain: by default one with every population and plastic projection that the function names, of 1000
            neurons and synapses each.
        world: by default one with every topic of the function; the topics must then state their type.
    """

    def __init__(
        self, function: TransferFunction, brain: MockBrain | None = None, world: MockWorld | None = None
    ) -> None:
        self.function = function
        self.brain = MockBrain(_network_of(function)) if brain is None else brain
        self.world = MockWorld(_topics_of(function)) if world is None else world
        self._t_ns = 0
        function.unbind()
        function.reset()
        function.bind(self.brain, self.world)

    def set(self, **inputs: Any) -> None:
        """Set the inputs of the function.

        Args:
            inputs: by parameter: the message of a topic, with its time as a
                :class:`~nrp_core.dsl.parameters.ReceivedMessage`, the value of a variable, the voltage or
                rate of a device (a list for a device group), the spike times in ms of a recorder, the weights
                of a projection (one for all synapses, or one for each).

        Raises:
            TransferFunctionError: the function has no such input.
        """
        for parameter, value in inputs.items():
            self._set(parameter, self.function.adapters.get(parameter), value)

    def _set(self, parameter: str, adapter: object, value: Any) -> None:
        if isinstance(adapter, SubscribedTopic) and isinstance(value, ReceivedMessage):
            self.world.put(adapter.name, value.value, from_seconds(value.t))
        elif isinstance(adapter, SubscribedTopic):
            self.world.put(adapter.name, value)
        elif isinstance(adapter, Variable):
            adapter.value = value
        elif isinstance(adapter, Weights):
            adapter.values = value
            adapter.commit()
        elif isinstance(adapter, Device) and _is_read(adapter):
            _set_input(adapter, value)
        elif isinstance(adapter, DeviceGroup) and all(map(_is_read, adapter)):
            for device, one in zip(adapter, value, strict=True):
                _set_input(device, one)
        else:
            inputs = [name for name in self.function.parameters if name != parameter]
            hint = did_you_mean(parameter, inputs)
            raise TransferFunctionError(f"'{self.function.name}' has no input '{parameter}'{hint}")

    def run(self, t: float | None = None) -> Any:
        """Run the function, even if it is not due, and return its result.

        A function with ``calls="each"`` is called for each message that was set; the results are a list.

        Args:
            t: the time in seconds; by default 20 ms after the last run.
        """
        before_ns, self._t_ns = self._t_ns, self._t_ns + 20 * NS_PER_MS if t is None else from_seconds(t)
        each = self.function.calls == "each"
        calls = list(self.function.calls_due(before_ns)) if each else ONCE
        results = [self.function.run(self._t_ns, None, call) for call in calls]
        self.function.deliver()
        return results if each else results[0]

    def sent(self, topic: str) -> list[Any]:
        """Return every message on a topic, oldest first."""
        return self.world.sent(topic)


class _PortWithValues:
    """A port with values of a test."""

    def __init__(self, port: Any, **values: Any) -> None:
        self._port = port
        vars(self).update(values)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._port, name)


def _is_read(device: Device) -> bool:
    return not isinstance(device.port, SourcePort)


def _set_input(device: Device, value: Any) -> None:
    if isinstance(device.port, SpikeRecorderPort):
        times = np.sort(np.asarray(value, dtype=float))
        device.port.receive(Spikes(np.full(len(times), device.selection.ids[0]), times), milliseconds(0))
    else:
        device.port = _PortWithValues(device.port, **{device.port.quantity: value})


class _AnyBrain:
    """The root of a brain that has every population."""

    def __init__(self) -> None:
        self.sizes: dict[str, int] = {}
        self.projections: dict[str, Projection] = {}

    def __getattr__(self, name: str) -> Any:
        return Groups(self._named) if name == GROUP else self._named(name)

    def _named(self, name: str) -> Selection:
        self.sizes[name] = _POPULATION_SIZE
        return Selection(np.arange(_POPULATION_SIZE), name)

    def _projection(self, label: str) -> Projection:
        self._named(label)
        ends = np.arange(_POPULATION_SIZE, dtype=np.int32)
        each = np.ones(_POPULATION_SIZE)
        made = Projection(label, label, label, "excitatory", ends, ends, each, each, STDP)
        return self.projections.setdefault(label, made)

    def reward(self, learned: Projection) -> None:
        """Add synapses that reward the target of a projection."""
        label = f"{learned.label} (reward)"
        self.projections[label] = replace(
            learned, label=label, receptor="reward", synapse_type=STATIC, neuromodulation=Neuromodulation()
        )


def _network_of(function: TransferFunction) -> Network:
    root = _AnyBrain()
    shown = [function.sink] if isinstance(function, MonitoringFunction) else []
    for mapping in (*function.mappings.values(), *shown):
        if isinstance(mapping, (MapSpikeSink, MapSpikeSource)):
            select(mapping.selector, root)
        elif isinstance(mapping, (MapReward, MapWeights)):
            learned = select_projection(mapping.selector, root)
            if isinstance(mapping, MapReward):
                root.reward(learned)
    populations = {name: Population(name, n, _CELL, {}) for name, n in root.sizes.items()}
    return Network(populations, tuple(root.projections.values()))


def _topics_of(function: TransferFunction) -> dict[str, type]:
    topics = [*function.subscribed, *function.published]
    return {topic.name: topic.topic_type for topic in topics if topic.topic_type is not None}
