"""The entry point of MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from math import isclose
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from nrp_core.clock import seconds
from nrp_core.scene.model import Scene
from nrp_core.world.backend import WorldOptions
from nrp_core.world.engine import Engine
from nrp_core.world.engine_kit.jointed import PhysicsBackend, PhysicsOptions
from nrp_world_mujoco.one_file import settings_of_scene, step_of

if TYPE_CHECKING:
    from nrp_core.world.engine_kit.jointed import JointedEngine


class MujocoOptions(PhysicsOptions):
    """Options of the ``mujoco`` backend."""

    impratio: Annotated[
        float | None,
        Field(
            ge=1,
            le=1000,
            description="ratio of the impedances of friction and contacts; held objects hardly slide with "
            "100. By default that of the scene's MJCF file, or 1",
        ),
    ] = None


class MujocoBackend(PhysicsBackend):
    """Scenes in MuJoCo."""

    options = MujocoOptions
    interface_version = 2
    engine_name = "MuJoCo"
    remedy = "pip install --force-reinstall mujoco-core"
    releases_gil = True
    own_actuators = True
    wrapping = True
    muscles = True

    def another(self, first: Engine, *, seed: int, options: WorldOptions) -> Engine:
        from nrp_world_mujoco.engine import MujocoEngine

        assert isinstance(first, MujocoEngine)
        return first.copy(seed)

    def fit(
        self, options: WorldOptions, scene: Scene, period_ns: int | None = None
    ) -> tuple[WorldOptions, str]:
        settings = None if "timestep" in options.model_fields_set else settings_of_scene(scene)
        if settings is None:
            return options, ""
        step_ns = step_of(settings, period_ns)
        own_s, step_s = float(settings.attribute("timestep") or 0), seconds(step_ns)
        fitting = options.model_copy(update={"timestep": step_ns})
        if isclose(own_s, step_s):
            return fitting, ""
        message = f"the time step of the scene's file, {own_s:g} s, does not divide the loop's"
        return fitting, f"{message}: {step_s:g} s is used"

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        return super().engine(scene, seed=seed, options=self.fit(options, scene)[0])

    def _engine_class(self) -> Callable[..., JointedEngine]:
        from nrp_world_mujoco.engine import MujocoEngine

        return MujocoEngine
