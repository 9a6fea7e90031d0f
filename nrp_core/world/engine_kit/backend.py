"""The shared part of backends of physics engines: options, capabilities, opening."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from nrp_core._support.diagnosis import Diagnosis
from nrp_core.errors import BackendLoadError
from nrp_core.simulation import Determinism
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.engine_kit.jointed import JointedEngine
from nrp_core.world.engine_kit.options import PhysicsOptions
from nrp_core.world.interface import WorldBackend, WorldOptions
from nrp_core.world.render.cameras import RASTER, REALISTIC, SHARED
from nrp_core.world.scene.model import Scene


class PhysicsBackend(WorldBackend):
    """The entry point of a physics engine with joints, contacts and cameras.

    Attributes:
        engine_name: name of the engine, for messages.
        remedy: command that installs it.
        releases_gil: whether it releases the GIL while it steps.
        own_actuators: whether it has the actuators that elements for it describe.
    """

    options: ClassVar[type[PhysicsOptions]]
    engine_name: ClassVar[str]
    remedy: ClassVar[str]
    releases_gil: ClassVar[bool] = False
    own_actuators: ClassVar[bool] = False

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, PhysicsOptions)
        auto = options.renderer == "auto"
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.MACHINE,
            renderers=(*SHARED, *self._own_renderers()) if auto else (options.renderer,),
            snapshot=True,
            links=True,
            contacts=True,
            joint_control=True,
            joint_wrenches=True,
            ball_joints=True,
            ball_control=True,
            loops=True,
            coupled_joints=True,
            changes=True,
            own_actuators=self.own_actuators,
            slip=float(options.drive == "physical"),
            releases_gil=self.releases_gil,
        )

    def diagnose(self) -> list[Diagnosis]:
        own = "".join(f", {name}" for name in self._own_renderers())
        meaning = f"{RASTER} (flat colours), {REALISTIC} (light and shadows){own}"
        return [Diagnosis("renderers of cameras", True, meaning)]

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        assert isinstance(options, self.options)
        try:
            engine = self._engine_class()
        except ImportError as error:
            raise BackendLoadError(
                f"{self.engine_name} does not import: {error}", remedy=self.remedy
            ) from error
        return engine(scene, seed=seed, capabilities=self.capabilities(options), options=options)

    @abstractmethod
    def _own_renderers(self) -> tuple[str, ...]:
        """Return the engine's own renderers that work on this machine."""

    @abstractmethod
    def _engine_class(self) -> Callable[..., JointedEngine]:
        """Import the engine and return its class."""
