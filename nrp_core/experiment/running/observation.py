"""The observations of a run: events, criteria, falls, the trajectories of robots, and counts of spikes."""

from __future__ import annotations

import hashlib
import re
import struct
from collections.abc import Collection, Iterable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import SinkPort, SinkSpec
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes
from nrp_core.cle import ClosedLoop
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError
from nrp_core.experiment.making.watch import Watch
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.network.data import Network
from nrp_core.network.indices import indices_of
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.raycast.solids import can_fall, room_of
from nrp_core.world.world import World

DEPTH_M = 2.0
"""A robot has fallen if it is this far below everything that is static, or below its start without a room."""


def bodies_fall(capabilities: WorldCapabilities) -> bool:
    """Return whether a world lets the bodies of its scene fall."""
    return capabilities.dynamics and not capabilities.own_scene


class FallWatch:
    """Checks the height of robots at every step, and reports the first time of each fall.

    Args:
        scene: the scene with the robots at their start poses.
        robots: names of the robots.
        capabilities: capabilities of the world; without dynamics nothing is checked.
    """

    def __init__(self, scene: Scene, robots: Collection[str], capabilities: WorldCapabilities) -> None:
        self._limits_m = dict(_limits_m(scene, robots)) if bodies_fall(capabilities) else {}
        self.reset()

    def reset(self) -> None:
        """Forget all falls."""
        self._fallen: dict[str, Finding] = {}

    def another(self) -> FallWatch:
        """Return one for a copy of the run, which has not seen any falls."""
        watch = copy(self)
        watch.reset()
        return watch

    def check(self, now_ns: int, poses: Mapping[str, Pose]) -> None:
        """Check the poses at a time."""
        for name, limit_m in self._limits_m.items():
            if name not in self._fallen and name in poses and poses[name].position[2] < limit_m:
                message = (
                    f"the robot '{name}' has fallen {DEPTH_M:g} m below the room: it is at z "
                    f"{poses[name].position[2]:.2f} m at {seconds(now_ns):g} s"
                )
                self._fallen[name] = Finding(Code.NRP292, message, Level.WARNING, subject=name)

    def limits_m(self, models: Iterable[str]) -> list[float]:
        """Return the heights below which models have fallen; minus infinity for one that cannot."""
        return [self._limits_m.get(name, -inf) for name in models]

    def findings(self) -> list[Finding]:
        """Return a finding for each robot that has fallen."""
        return list(self._fallen.values())


def _limits_m(scene: Scene, robots: Collection[str]) -> Iterator[tuple[str, float]]:
    """Yield each robot that can fall, and the height below which it has fallen."""
    room_m = min((solid.lowest_m for solid in room_of(scene)), default=None)
    for model in scene.models:
        if model.name in robots and can_fall(model, scene):
            start_m = model.pose.position[2]
            lowest_m = start_m if room_m is None else min(room_m, start_m)
            if isfinite(lowest_m):
                yield model.name, lowest_m - DEPTH_M


_AT_ONCE = 64
"""Windows whose spikes are counted together; for a few spikes the call costs more than the sum."""
_AUTOMATIC = re.compile(r"population\d+")
"""Automatic names of populations without a label in their script."""


@dataclass(frozen=True, slots=True)
class SpikeCounter(SinkSpec):
    """Counts the spikes of each neuron."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> SpikeCounterPort:
        return SpikeCounterPort(neurons, n_neurons, name)


class SpikeCounterPort(SinkPort):
    """A connected spike counter."""

    def __init__(self, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self._sums = np.zeros(n_neurons, np.int64)
        self._uncounted: list[IntArray] = []
        self._reached: IntArray | None = None

    @property
    def counted(self) -> IntArray | None:
        return self._sums if self.active and self._receives_all else None

    def activity(self, network: Network) -> dict[str, int]:
        """Return the number of all spikes, and of the synapses that they reached."""
        if self._reached is None:
            self._reached = synapses_from(network)
        return {"spikes": int(self._counts.sum()), "synaptic_events": int(self._counts @ self._reached)}

    def of(self, network: Network) -> dict[str, int]:
        """Return the spikes of every view and population by its name.

        A population with an automatic name is omitted if a view has the same neurons.
        """
        named = {label: network.neurons(label) for label in network.views}
        viewed = {neurons.tobytes() for neurons in named.values()}
        for label in network.populations:
            neurons = network.neurons(label)
            if label not in named and not (_AUTOMATIC.fullmatch(label) and neurons.tobytes() in viewed):
                named[label] = neurons
        return {label: int(self._counts[neurons].sum()) for label, neurons in named.items()}

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        if len(spikes):
            self._uncounted.append(spikes.neurons)
            if len(self._uncounted) >= _AT_ONCE:
                self._count()

    def _count(self) -> None:
        for neurons in (np.concatenate(self._uncounted),) if self._uncounted else ():
            np.add.at(self._sums, neurons, 1)
        self._uncounted.clear()

    @property
    def _counts(self) -> IntArray:
        """The number of spikes of each neuron."""
        self._count()
        return self._sums

    def reset(self) -> None:
        self._uncounted.clear()
        self._sums[:] = 0

    def save(self) -> object:
        return self.active, self._counts.copy()

    def restore(self, saved: Any) -> None:
        self.active, counts = saved
        self._counts[:] = counts


def synapses_from(network: Network) -> IntArray:
    """Return the number of synapses of each neuron that its spikes pass, shape ``(n_neurons,)``."""
    found = np.zeros(network.size, np.int64)
    for projection in (one for one in network.projections if not one.is_continuous):
        of_population = found[network.offsets[projection.pre] :]
        for pre in indices_of(projection, "pre_index").parts():
            counts = np.bincount(pre)
            of_population[: len(counts)] += counts
    return found


@dataclass(frozen=True, slots=True)
class Trail:
    """Where an engine has the numbers of the digest of a trajectory.

    Args:
        scene: the scene for which this is valid.
        positions: an array in which the engine keeps positions.
        places: their indices: the pose of each model that moves, then the positions of all joints.
        kind: the number of models that move, and of the joints.
    """

    scene: Scene
    positions: FloatArray
    places: IntArray
    kind: tuple[int, bytes]


class Observation:
    """Observes a run once for each time.

    Args:
        experiment: the experiment.
        falls: reports robots that fall.
        world: its open world, with the topics and aliases of the experiment.
        collector: receives mistakes in events and criteria.

    Attributes:
        watch: the events and criteria of the experiment.
        digest: the digest of the trajectories of all models so far.
        engine: the engine of the world.
        period_ns: one step of the loop.
        trail: the numbers of the trajectories, while arrays evaluate the events and criteria.
        table: the arrays; see :class:`~nrp_core.experiment.running.many_observations.ManyObservations`.
        alone_for, patience: number of steps without arrays, now and after the next one that needs it.
    """

    trail: Trail | None = None
    table: Any = None
    alone_for, patience = 0, 1

    def __init__(self, experiment: Experiment, falls: FallWatch, world: World, collector: Collector) -> None:
        self.engine, self.period_ns = world.engine, experiment.timestep
        self.watch = Watch(experiment, world, collector)
        self._robots, self._world = experiment.world.robots, world
        self._scene: Scene | None = None
        self.falls = falls
        self._begin()

    def count_spikes(self, brain: Brain) -> None:
        """Count the spikes of all neurons of an open brain from now on."""
        self._network = brain.network
        port = brain.add_sink(SpikeCounter(), np.arange(brain.network.size), name="result")
        self.watch.around.brain, self.watch.around.spikes = brain, lambda: self.spikes
        self._counter: SpikeCounterPort = port  # type: ignore[assignment]  # as its specification opens it

    @property
    def spikes(self) -> dict[str, int]:
        """The number of spikes so far, by population and view."""
        return dict(self._counter.of(self._network))

    @property
    def activity(self) -> dict[str, int]:
        """The number of all spikes so far, and of the synapses that they reached."""
        return self._counter.activity(self._network)

    def _begin(self) -> None:
        self._looked_at_ns: int | None = None
        self.digest = TrajectoryDigest()

    def evaluate(self, loop: ClosedLoop) -> None:
        """Evaluate a time, after the step to it or before the first step; once for each time."""
        now_ns = loop.now_ns
        if now_ns != self._looked_at_ns:
            self._looked_at_ns = now_ns
            self.watch.evaluate(now_ns)
            self.digest.add(*self._state())
            self.falls.check(now_ns, self.watch.where.poses)

    def poses(self) -> dict[str, Pose]:
        """Return the poses of the present robots; a robot may be missing after an error or a deletion."""
        where = self.watch.where
        return {name: where.pose(name) for name in self._robots if name in where}

    def _state(self) -> tuple[list[Pose], list[FloatArray]]:
        """Return the poses of all models that can move, and the positions of their joints."""
        poses, engine = self.watch.where.poses, self._world.engine
        if engine.scene is not self._scene:
            self._scene = engine.scene
            self._moving = [model.name for model in self._scene.models if not model.static]
            self._jointed = [model.name for model in self._scene.models if self._has_joints(model)]
        seen, joints = [], []
        for name in self._moving:
            if name in poses:
                seen.append(poses[name])  # noqa: PERF401  in each step: a comprehension is one more call
        for name in self._jointed:
            if name in poses:
                joints.append(engine.joint_positions(name))  # noqa: PERF401  as above
        return seen, joints

    # -- in many copies at once

    def waits_alone(self) -> bool:
        """Return whether it evaluates this step without arrays; called once for each."""
        self.alone_for = max(0, self.alone_for - 1)
        return self.alone_for > 0 or self._looked_at_ns is None

    def find_trail(self) -> Trail | None:
        """Find where the engine has the numbers of the trajectories; None: it does not tell."""
        self._state()
        places = self.engine.position_places(self._moving, self._jointed)
        self.trail = None
        if places is not None:
            positions, indices = places
            self.trail = Trail(self.engine.scene, positions, indices, (len(self._moving), indices.tobytes()))
        return self.trail

    def pass_quietly(self, trajectory: bytes, poses: FloatArray) -> None:
        """Process a time at which nothing happens.

        Args:
            trajectory: the numbers of the digest.
            poses: those of the models that move, shape ``(models, 7)``.
        """
        self._looked_at_ns = now_ns = self.engine.now_ns
        self.patience = 1
        self.digest.add_bytes(trajectory)
        self.watch.where.set_numbers(poses)
        self.watch.pass_quietly(now_ns)

    def _has_joints(self, model: Model) -> bool:
        """Return whether a model has joints that move, and the engine reports them."""
        if model.static or model.name not in self.watch.where:
            return False
        try:
            return bool(len(self._world.engine.joint_states(model.name).names))
        except CapabilityError:
            return False

    def reset(self) -> None:
        """Reset to time 0."""
        self.watch.reset()
        self.falls.reset()
        self._begin()

    def save(self) -> tuple[Any, ...]:
        """Return the state, as a part of a snapshot."""
        return self._looked_at_ns, self.digest.state, self.watch.save()

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Restore a state from :meth:`save`, in a world that was restored."""
        self._looked_at_ns, self.digest.state, watched = saved
        self.watch.restore(watched)


class TrajectoryDigest:
    """A hash of poses and positions of joints, bit for bit; equal digests, equal trajectories.

    The digest of each step is made from the previous one, so the state is a few bytes.

    Attributes:
        state: the digest so far.
    """

    def __init__(self) -> None:
        self.state = b""

    def add(self, poses: Iterable[Pose], joints: Iterable[FloatArray]) -> None:
        """Add the poses of models and the positions of joints after one more step."""
        state = hashlib.blake2b(self.state, digest_size=16)
        for pose in poses:
            state.update(struct.pack("<7d", *pose.position, *pose.orientation))
        for each in joints:
            state.update(np.ascontiguousarray(each, "<f8").data)
        self.state = state.digest()

    def add_bytes(self, numbers: bytes) -> None:
        """Add the same numbers as bytes."""
        self.state = hashlib.blake2b(self.state + numbers, digest_size=16).digest()

    def hexdigest(self) -> str:
        """Return the digest so far."""
        return self.state.hex()
