"""The entry point: options, capabilities, opening."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Annotated, Literal

from pydantic import Field

from nrp_core.diagnosis import Diagnosis
from nrp_core.errors import BackendLoadError
from nrp_core.simulation import Determinism
from nrp_core.world.interface import World, WorldBackend, WorldCapabilities, WorldOptions
from nrp_core.world.physics.options import PhysicsOptions
from nrp_core.world.scene.model import Scene

REMEDY = "pip install 'nrp-core[pybullet]'"


class PybulletOptions(PhysicsOptions):
    """Options of the ``pybullet`` backend."""

    renderer: Annotated[
        Literal["auto", "raster", "tiny"],
        Field(description="of cameras: raster draws on the CPU, tiny is PyBullet's own, slower way to do so"),
    ] = "auto"


class PybulletBackend(WorldBackend):
    """Scenes in PyBullet."""

    options = PybulletOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, PybulletOptions)
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.MACHINE,
            renderers=("raster", "tiny") if options.renderer == "auto" else (options.renderer,),
            snapshot=True,
            links=True,
            contacts=True,
            joint_control=True,
            joint_wrenches=True,
            changes=True,
            releases_gil=False,
        )

    def diagnose(self) -> list[Diagnosis]:
        if find_spec("pybullet") is not None:
            return [Diagnosis("PyBullet", True, "worlds can run in PyBullet")]
        meaning = "no wheel for this Python and platform; worlds run in other engines"
        remedy = f"{REMEDY}  # compiles it, about 12 minutes"
        return [Diagnosis("PyBullet", False, meaning, remedy, needed=True)]

    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        assert isinstance(options, PybulletOptions)
        try:
            from nrp_world_pybullet.world import PybulletWorld
        except ImportError as error:
            raise BackendLoadError(f"PyBullet does not import: {error}; try: {REMEDY}") from error
        return PybulletWorld(scene, seed=seed, capabilities=self.capabilities(options), options=options)
