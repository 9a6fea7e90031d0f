"""Options of the ``mujoco`` backend."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from nrp_core.world.engine_kit.options import PhysicsOptions


class MujocoOptions(PhysicsOptions):
    """Options of the ``mujoco`` backend."""

    renderer: Annotated[
        Literal["auto", "raster", "realistic", "gl", "rays"],
        Field(
            description="of cameras: raster draws flat colours on the CPU, realistic light and shadows, "
            "gl flat ones by EGL or OSMesa, rays by MuJoCo's ray casts"
        ),
    ] = "auto"
