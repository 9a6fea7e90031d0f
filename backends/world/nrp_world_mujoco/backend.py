"""The entry point: the engine's renderers, and how it is opened."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from nrp_core._support.diagnosis import Diagnosis
from nrp_core.errors import CapabilityError
from nrp_core.world.engine import Engine
from nrp_core.world.engine_kit.jointed import PhysicsBackend
from nrp_core.world.interface import WorldOptions
from nrp_core.world.scene.model import Scene
from nrp_world_mujoco.options import MujocoOptions, headless_library

if TYPE_CHECKING:
    from nrp_core.world.engine_kit.jointed import JointedEngine

GL_REMEDY = "apt-get install --no-install-recommends libegl1 libgl1 && pip install 'nrp-core[gl]'"


class MujocoBackend(PhysicsBackend):
    """Scenes in MuJoCo."""

    options = MujocoOptions
    interface_version = 2
    engine_name = "MuJoCo"
    remedy = "pip install --force-reinstall mujoco-core"
    releases_gil = True
    own_actuators = True
    muscles = True

    def diagnose(self) -> list[Diagnosis]:
        library = headless_library()
        if library is not None:
            meaning = f"cameras of MuJoCo worlds can be drawn by OpenGL ({library}) with renderer: gl"
            return [Diagnosis("OpenGL without a display", True, meaning), *super().diagnose()]
        meaning = "cameras of MuJoCo worlds are drawn on the CPU (renderer: raster), as exactly"
        return [Diagnosis("OpenGL without a display", False, meaning, GL_REMEDY), *super().diagnose()]

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        if getattr(options, "renderer", None) == "gl" and headless_library() is None:
            raise CapabilityError(
                f"the renderer 'gl' does not work on this machine; use 'raster', or try: {GL_REMEDY}"
            )
        return super().engine(scene, seed=seed, options=options)

    def another(self, first: Engine, *, seed: int, options: WorldOptions) -> Engine:
        from nrp_world_mujoco.engine import MujocoEngine

        assert isinstance(first, MujocoEngine)
        return first.copy(seed)

    def _own_renderers(self) -> tuple[str, ...]:
        return ("gl", "rays") if headless_library() else ("rays",)

    def _engine_class(self) -> Callable[..., JointedEngine]:
        from nrp_world_mujoco.engine import MujocoEngine

        return MujocoEngine
