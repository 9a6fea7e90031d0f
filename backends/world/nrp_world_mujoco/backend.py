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
        Literal["auto", "raster", "gl", "rays"],
        Field(
            description="of cameras: raster draws on the CPU, gl by EGL or OSMesa, rays by MuJoCo's ray casts"
        ),
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
            links=True,
            contacts=True,
            joint_control=True,
            joint_wrenches=True,
            changes=True,
            releases_gil=True,
        )

    def diagnose(self) -> list[Diagnosis]:
        library = headless.library()
        if library is not None:
            meaning = f"cameras of MuJoCo worlds can be drawn by OpenGL ({library}) with renderer: gl"
            return [Diagnosis("OpenGL without a display", True, meaning)]
        meaning = "cameras of MuJoCo worlds are drawn on the CPU (renderer: raster), as exactly"
        return [Diagnosis("OpenGL without a display", False, meaning, GL_REMEDY)]

    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        assert isinstance(options, MujocoOptions)
        capabilities = self.capabilities(options)
        if options.renderer == "gl" and headless.library() is None:
            raise CapabilityError(
                f"the renderer 'gl' does not work on this machine; use 'raster', or try: {GL_REMEDY}"
            )
        try:
            from nrp_world_mujoco.world import MujocoWorld
        except ImportError as error:
            raise BackendLoadError(
                f"MuJoCo does not import: {error}; try: pip install --force-reinstall mujoco-core"
            ) from error
        return MujocoWorld(scene, seed=seed, capabilities=capabilities, options=options)

    def _open_again(self, first: World, *, seed: int, options: WorldOptions) -> World:
        from nrp_world_mujoco.world import MujocoWorld

        assert isinstance(first, MujocoWorld)
        return first.copy(seed)


def _renderers(options: MujocoOptions) -> tuple[str, ...]:
    if options.renderer == "auto":
        return ("raster", "gl", "rays") if headless.library() else ("raster", "rays")
    return (options.renderer,)
