"""The entry point of MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from nrp_core.world.backend import WorldOptions
from nrp_core.world.engine import Engine
from nrp_core.world.engine_kit.jointed import PhysicsBackend, PhysicsOptions

if TYPE_CHECKING:
    from nrp_core.world.engine_kit.jointed import JointedEngine


class MujocoBackend(PhysicsBackend):
    """Scenes in MuJoCo."""

    options = PhysicsOptions
    interface_version = 2
    engine_name = "MuJoCo"
    remedy = "pip install --force-reinstall mujoco-core"
    releases_gil = True
    own_actuators = True
    muscles = True

    def another(self, first: Engine, *, seed: int, options: WorldOptions) -> Engine:
        from nrp_world_mujoco.engine import MujocoEngine

        assert isinstance(first, MujocoEngine)
        return first.copy(seed)

    def _engine_class(self) -> Callable[..., JointedEngine]:
        from nrp_world_mujoco.engine import MujocoEngine

        return MujocoEngine
