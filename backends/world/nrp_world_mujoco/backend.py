"""The entry point: options, capabilities, opening."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from nrp_core.diagnosis import Diagnosis
from nrp_core.errors import BackendLoadError, CapabilityError
from nrp_core.simulation import Determinism
from nrp_core.world.interface import World, WorldBackend, WorldCapabilities, WorldOptions
from nrp_core.world.physics.options import PhysicsOptions
from nrp_core.world.scene.model import Scene
from nrp_world_mujoco import headless

GL_REMEDY = "apt-get install --no-install-recommends libegl1 libgl1 && pip install 'nrp-core[gl]'"


class MujocoOptions(PhysicsOptions):
    """Options of the ``mujoco`` backend."""

    renderer: Annotated[
        Literal["auto", "gl", "rays"],
        Field(description="of cameras: gl needs EGL or OSMesa; rays needs nothing, for low resolutions"),
    ] = "auto"


class MujocoBackend(WorldBackend):
    """Scenes in MuJoCo."""

    options = MujocoOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, MujocoOptions)
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.MACHINE,
            renderers=_renderers(options),
            snapshot=True,
            releases_gil=True,
        )

    def diagnose(self) -> list[Diagnosis]:
        library = headless.library()
        if library is not None:
            found = f"cameras are drawn by OpenGL ({library})"
            return [Diagnosis("OpenGL without a display", True, found)]
        meaning = "cameras are ray-cast (renderer: rays): as exact, but slow above about 100x75 pixels"
        return [Diagnosis("OpenGL without a display", False, meaning, GL_REMEDY)]

    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        assert isinstance(options, MujocoOptions)
        capabilities = self.capabilities(options)
        if options.renderer == "gl" and headless.library() is None:
            raise CapabilityError(
                f"renderer 'gl' does not work on this machine; use 'rays', or try: {GL_REMEDY}"
            )
        try:
            from nrp_world_mujoco.world import MujocoWorld
        except ImportError as error:
            raise BackendLoadError(
                f"MuJoCo does not import: {error}; try: pip install --force-reinstall mujoco-core"
            ) from error
        return MujocoWorld(scene, seed=seed, capabilities=capabilities, options=options)


def _renderers(options: MujocoOptions) -> tuple[str, ...]:
    if options.renderer == "auto":
        return ("gl", "rays") if headless.library() else ("rays",)
    return (options.renderer,)
