"""Options of all physics engines."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs
from nrp_core.world.interface import WorldOptions


class PhysicsOptions(WorldOptions):
    """Options of a world in a physics engine; a backend adds its own choices to ``renderer``."""

    timestep: Annotated[DurationNs, Field(description="the physics step")] = 2 * NS_PER_MS
    image_scale: Annotated[
        float, Field(ge=0.01, le=1, description="scales width and height of every camera, for speed")
    ] = 1.0
    drive: Annotated[
        Literal["planar", "physical"],
        Field(
            description="how wheels move a robot: planar moves the body as commanded, "
            "physical only turns the wheels"
        ),
    ] = "planar"
    renderer: str = "auto"
