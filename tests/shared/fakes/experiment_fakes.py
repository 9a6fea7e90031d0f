"""Two engines without a simulator: a brain that only counts, and a world of discs that drive."""

from math import cos, sin
from typing import Any

import numpy as np
from pydantic import Field

from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import seconds
from nrp_core.network.data import Network
from nrp_core.quantities import DurationNs
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import BodyVelocity, ModelMotion, Pose
from nrp_core.world.backend import WorldBackend, WorldOptions
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine


class CountingBrain(Brain):
    """Every neuron that is sent an event spikes at once."""

    def __init__(self, network: Network, **settings: Any) -> None:
        super().__init__(network, **settings)
        self._do_reset(0)

    def _do_run_until(self, t_ns: int) -> None: ...

    def _do_take_spikes(self) -> Spikes:
        spikes, self._spikes = Spikes.merged(self._spikes), []
        return spikes

    def _do_fire(self, neurons: Any, times_ms: Any) -> None: ...

    def _do_inject(self, events: SynapticEvents) -> None:
        self._spikes.append(Spikes(events.neurons, events.times_ms))

    def _do_set_current(self, currents_na: Any) -> None: ...

    def _do_reset(self, seed: int) -> None:
        self._spikes: list[Spikes] = []

    def _do_close(self) -> None: ...


class CountingOptions(BrainOptions):
    resolution: DurationNs | None = None
    """Grid of the spikes."""


class CountingBackend(BrainBackend):
    options = CountingOptions

    def capabilities(self, options: Any) -> BrainCapabilities:
        cells = frozenset({"IF_curr_exp", "IF_cond_alpha"})
        return BrainCapabilities(cells, frozenset({"static"}), resolution_ns=options.resolution)

    def open(self, network: Network, *, seed: int, options: Any) -> Brain:
        capabilities = self.capabilities(options)
        return CountingBrain(network, seed=seed, capabilities=capabilities, identity="counting")


class DiscOptions(WorldOptions):
    timestep: DurationNs = 2_000_000
    """The physics step."""
    renderer: str = Field("none", pattern="none|all")


class DiscEngine(Engine):
    """Every model that is not static moves exactly as its drive is told; cameras see one colour."""

    def __init__(self, scene: Scene, capabilities: WorldCapabilities, **settings: Any) -> None:
        super().__init__(scene, capabilities, **settings)
        self._do_reset(0)

    def _do_reset(self, seed: int) -> None:
        self._poses = {model.name: model.pose for model in self.scene.models}
        self._velocities: dict[str, BodyVelocity] = {}
        self.colors: dict[str, Any] = {}
        self.fails_at_ns: int | None = None
        self._t_ns = 0

    def _do_advance(self, steps: int) -> None:
        self._t_ns += steps * self.capabilities.step_ns
        dt = seconds(self.capabilities.step_ns)
        for name, velocity in self._velocities.items():
            for _ in range(steps):
                self._poses[name] = _moved(self._poses[name], velocity, dt)

    def _do_model_motion(self, model: str) -> ModelMotion:
        return ModelMotion(self._poses[model])

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._velocities[model] = velocity

    def _do_set_color(self, visual: str, rgba: Any) -> None:
        self.colors[visual] = rgba

    def _do_render(self, model: str, link: str, camera: str) -> Any:
        return np.zeros((2, 2, 3), np.uint8)

    def _do_close(self) -> None: ...


def _moved(pose: Pose, velocity: BodyVelocity, dt: float) -> Pose:
    x, y, z = pose.position
    yaw = pose.yaw + velocity.turn * dt
    step = velocity.forward * dt
    return Pose.from_rpy((x + step * cos(yaw), y + step * sin(yaw), z), 0.0, 0.0, yaw)


class DiscBackend(WorldBackend):
    interface_version = 2
    options = DiscOptions

    def capabilities(self, options: Any) -> WorldCapabilities:
        return WorldCapabilities(step_ns=options.timestep)

    def engine(self, scene: Scene, *, seed: int, options: Any) -> Engine:
        return DiscEngine(scene, self.capabilities(options), seed=seed, identity="disc")
