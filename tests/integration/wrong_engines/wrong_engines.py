"""Engines with one bug each: all are MuJoCo, or the brain ``event``, but for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from nrp_brain_event import EventBackend
from nrp_world_mujoco import MujocoBackend
from nrp_world_mujoco.engine import MujocoEngine

from nrp_core.scene.devices import Noise
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import BodyVelocity, Pose
from nrp_core.world.sensors.navigation import Imu
from nrp_core.world.sensors.sensor import with_imperfection


class _Opens(MujocoBackend):
    Opened: type[MujocoEngine] = MujocoEngine

    def engine(self, scene: Scene, *, seed: int, options: Any) -> Any:
        scene = self.changed(scene)
        return self.Opened(scene, seed=seed, capabilities=self.capabilities(options), options=options)

    def changed(self, scene: Scene) -> Scene:
        return scene


class SameWorld(_Opens):
    """A copy without a bug."""


def _with_drive(change: Callable[[BodyVelocity], BodyVelocity]) -> type[MujocoEngine]:
    class Changed(MujocoEngine):
        def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
            super()._do_set_drive(model, drive, change(velocity))

    return Changed


class LateCommands(_Opens):
    """Every command acts a step of the loop later."""

    class Opened(MujocoEngine):
        def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
            late = self.__dict__.setdefault("late", {})
            before = late.get((model, drive), BodyVelocity())
            late[model, drive] = velocity
            super()._do_set_drive(model, drive, before)


class LargeWheels(_Opens):
    """Its wheels are 2 % larger than its drives believe."""

    Opened = _with_drive(lambda v: replace(v, forward=1.02 * v.forward, turn=1.02 * v.turn))


class ReversedGear(_Opens):
    """It turns to the right when commanded to the left."""

    Opened = _with_drive(lambda v: replace(v, turn=-v.turn))


class BlueFirst(_Opens):
    """Its cameras give blue first."""

    class Opened(MujocoEngine):
        def _do_render(self, model: str, link: str, camera: str) -> Any:
            return super()._do_render(model, link, camera)[:, :, ::-1].copy()


class LightGravity(_Opens):
    """Gravity is 9 m/s²."""

    def changed(self, scene: Scene) -> Scene:
        return replace(scene, gravity=(0.0, 0.0, -9.0))


def _with_links(scene: Scene, change: Callable[[Any], Any]) -> Scene:
    models = [replace(m, links=tuple(map(change, m.links))) for m in scene.models]
    return replace(scene, models=tuple(models))


class HeavyLinks(_Opens):
    """Every link weighs 20 % more."""

    def changed(self, scene: Scene) -> Scene:
        def heavier(link: Any) -> Any:
            if link.inertial is None:
                return link
            return replace(link, inertial=replace(link.inertial, mass=1.2 * link.inertial.mass))

        return _with_links(scene, heavier)


class SlipperyGround(_Opens):
    """Friction is half as large."""

    def changed(self, scene: Scene) -> Scene:
        def slippery(link: Any) -> Any:
            shapes = (replace(shape, friction=0.5 * shape.friction) for shape in link.collisions)
            return replace(link, collisions=tuple(shapes))

        return _with_links(scene, slippery)


class NoisyScanner(_Opens):
    """Its scanner has noise of 15 cm."""

    def changed(self, scene: Scene) -> Scene:
        return with_imperfection(scene, "/cart/scan", noise=Noise(0.0, 0.15))


class LateInertialSensor(_Opens):
    """Its inertial sensor arrives 40 ms late."""

    def changed(self, scene: Scene) -> Scene:
        return with_imperfection(scene, "/cart/imu", delay=0.04)


class TurnedInertialSensor(_Opens):
    """The frame of its inertial sensor is turned by a quarter about x."""

    def changed(self, scene: Scene) -> Scene:
        def turned(sensor: Any) -> Any:
            quarter = Pose((0.0, 0.0, 0.0), (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
            return replace(sensor, pose=quarter) if isinstance(sensor, Imu) else sensor

        return _with_links(scene, lambda link: replace(link, sensors=tuple(map(turned, link.sensors))))


class SameBrain(EventBackend):
    """A copy without a bug."""

    def open(self, network: Any, *, seed: int, options: Any) -> Any:
        return super().open(self.changed(network), seed=seed, options=options)

    def changed(self, network: Any) -> Any:
        return network


def _with_weights(network: Any, change: Callable[[Any], Any]) -> Any:
    return replace(network, projections=tuple(map(change, network.projections)))


def _with_cells(network: Any, **changes: Callable[[Any], Any]) -> Any:
    def changed(population: Any) -> Any:
        if population.is_source:
            return population
        values = {name: change(population.parameters[name]) for name, change in changes.items()}
        return replace(population, parameters={**population.parameters, **values})

    populations = {label: changed(one) for label, one in network.populations.items()}
    return replace(network, populations=populations)


class StrongSynapses(SameBrain):
    """Weights are 5 % larger."""

    def changed(self, network: Any) -> Any:
        return _with_weights(network, lambda one: replace(one, weight=1.05 * one.weight))


class FlippedSynapses(SameBrain):
    """What inhibits excites."""

    def changed(self, network: Any) -> Any:
        def flipped(one: Any) -> Any:
            return replace(one, weight=abs(one.weight), receptor="excitatory")

        return _with_weights(network, flipped)


class HighThreshold(SameBrain):
    """Thresholds are 1 mV higher."""

    def changed(self, network: Any) -> Any:
        return _with_cells(network, v_thresh=lambda v: v + 1.0)


class LongRefractoryTime(SameBrain):
    """Cells are refractory for 1 ms longer."""

    def changed(self, network: Any) -> Any:
        return _with_cells(network, tau_refrac=lambda t: t + 1.0)


class SlowMembrane(SameBrain):
    """Membranes are 10 % slower."""

    def changed(self, network: Any) -> Any:
        return _with_cells(network, tau_m=lambda t: 1.1 * t)


class LostSpikes(EventBackend):
    """Every twentieth spike is lost before anybody hears it."""

    def open(self, network: Any, *, seed: int, options: Any) -> Any:
        brain = super().open(network, seed=seed, options=options)
        take, count = brain._do_take_spikes, [0]

        def some() -> Any:
            spikes = take()
            numbers = np.arange(count[0], count[0] + len(spikes.neurons))
            count[0] += len(spikes.neurons)
            kept = numbers % 20 != 19
            return type(spikes)(spikes.neurons[kept], spikes.times_ms[kept])

        brain._do_take_spikes = some
        return brain
