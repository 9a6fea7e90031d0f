"""Options of the ``pybullet`` backend."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from nrp_core.world.engine_kit.jointed import PhysicsOptions


class PybulletOptions(PhysicsOptions):
    """Options of the ``pybullet`` backend."""

    renderer: Annotated[
        Literal["auto", "raster", "realistic", "tiny"],
        Field(
            description="of cameras: raster draws flat colours on the CPU, realistic light and shadows, "
            "tiny is PyBullet's own, slower way to draw flat ones"
        ),
    ] = "auto"
