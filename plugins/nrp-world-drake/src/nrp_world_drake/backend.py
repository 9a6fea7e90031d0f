"""The entry point of Drake."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

from nrp_core.world import (
    Diagnosis,
    PhysicsBackend,
    PhysicsOptions,
    WorldCapabilities,
    WorldOptions,
    muscles_of,
)
from nrp_core.world.engine_kit.wrapping import wrapping_refusals

if TYPE_CHECKING:
    from nrp_core.world import JointedEngine, Scene


class DrakeBackend(PhysicsBackend):
    """Scenes in Drake, as a discrete plant with its SAP solver."""

    options = PhysicsOptions
    interface_version = 2
    engine_name = "Drake"
    remedy = "pip install 'nrp-core[drake]' && apt-get install libglib2.0-0 libsm6 libx11-6"
    muscles = True
    wrapping = True

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        return replace(super().capabilities(options), ball_control=False)

    def refusals(self, scene: Scene) -> Iterator[tuple[str, str]]:
        for model in scene.models:
            if any(muscle.wraps for muscle in muscles_of(model)):
                import mujoco

                yield from ((model.name, why) for why in wrapping_refusals(mujoco, self.engine_name, model))

    def diagnose(self) -> list[Diagnosis]:
        if find_spec("pydrake") is not None:
            return [Diagnosis("Drake", True, "worlds can run in Drake"), *super().diagnose()]
        return [
            Diagnosis("Drake", False, "not installed; worlds run in other engines", self.remedy, needed=True)
        ]

    def _engine_class(self) -> Callable[..., JointedEngine]:
        from nrp_world_drake.engine import DrakeEngine

        return DrakeEngine
