"""The entry point of PyBullet."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import TYPE_CHECKING

from nrp_core._support.diagnosis import Diagnosis
from nrp_core.world.drives.muscles import muscles_of
from nrp_core.world.engine_kit.jointed import PhysicsBackend, PhysicsOptions
from nrp_core.world.engine_kit.wrapping import wrapping_refusals

if TYPE_CHECKING:
    from nrp_core.scene.model import Scene
    from nrp_core.world.engine_kit.jointed import JointedEngine


class PybulletBackend(PhysicsBackend):
    """Scenes in PyBullet."""

    options = PhysicsOptions
    interface_version = 2
    engine_name = "PyBullet"
    remedy = "pip install 'nrp-core[pybullet]'"
    muscles = True
    wrapping = True

    def refusals(self, scene: Scene) -> Iterator[tuple[str, str]]:
        for model in scene.models:
            if any(muscle.wraps for muscle in muscles_of(model)):
                import mujoco

                yield from ((model.name, why) for why in wrapping_refusals(mujoco, self.engine_name, model))

    def diagnose(self) -> list[Diagnosis]:
        if find_spec("pybullet") is not None:
            return [Diagnosis("PyBullet", True, "worlds can run in PyBullet"), *super().diagnose()]
        time = "" if _has_wheel() else "  # compiles it, about 12 minutes"
        meaning = "not installed; worlds run in other engines"
        return [Diagnosis("PyBullet", False, meaning, self.remedy + time, needed=True)]

    def _engine_class(self) -> Callable[..., JointedEngine]:
        from nrp_world_pybullet.engine import PybulletEngine

        return PybulletEngine


def _has_wheel() -> bool:
    """Return whether the package index has PyBullet compiled for this Python and machine."""
    return sys.version_info < (3, 12) and sys.platform == "linux" and platform.machine() == "x86_64"
