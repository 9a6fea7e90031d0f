"""Options of the ``gazebo`` backend."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator

from nrp_core.world import PhysicsOptions

ROOT_VARIABLE = "NRP_GAZEBO_ROOT"
"""Environment variable with the default of the option ``root``."""


def default_root() -> Path | None:
    """Return the folder of another system that has Gazebo; None for this system."""
    chosen = os.environ.get(ROOT_VARIABLE)
    return Path(chosen) if chosen else None


class GazeboOptions(PhysicsOptions):
    """Options of the ``gazebo`` backend."""

    drive: Annotated[
        Literal["planar", "physical", "plugin"],
        Field(
            description="how wheels move a robot: planar moves the body as commanded, physical only turns "
            "the wheels, plugin leaves the commands to the plugin of Gazebo itself in the robot's file"
        ),
    ] = "planar"  # type: ignore[assignment]  # one choice more than other engines have
    rays: Annotated[
        Literal["shared", "gazebo"],
        Field(description="of lasers: shared casts them in nrp-core, alike in every engine; gazebo in ODE"),
    ] = "shared"
    renderer: Annotated[
        Literal["auto", "raster", "realistic", "gazebo"],
        Field(
            description="of cameras: raster draws flat colours on the CPU, realistic light and shadows, "
            "gazebo its own images"
        ),
    ] = "auto"  # type: ignore[assignment]  # likewise
    command: Annotated[
        tuple[str, ...],
        Field(description="the program and its first arguments; the name of the world file is added"),
    ] = ("gzserver",)
    root: Annotated[
        Path | None,
        Field(
            default_factory=default_root,
            description=f"a folder with another system in which Gazebo runs; by default ${ROOT_VARIABLE}",
        ),
    ]
    models: Annotated[
        Literal["file", "scene"],
        Field(description="file: Gazebo reads SDF models from their own files; scene: as nrp-core has them"),
    ] = "file"
    start_timeout: Annotated[float, Field(gt=0, description="the time that Gazebo may take to start, s")] = (
        60.0
    )
    step_timeout: Annotated[
        float, Field(gt=0, description="the time without an answer after which Gazebo has failed, s")
    ] = 60.0

    @field_validator("command", mode="before")
    @classmethod
    def _words(cls, command: object) -> object:
        return tuple(command.split()) if isinstance(command, str) else command
