"""Find the drives and controllers of a file: each is read by what is registered for its plugin."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

from nrp_core.registry import Registry
from nrp_core.world.scene.acting import JointController, MountedDrive, TrajectoryController
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.registered import ModelParts, registered
from nrp_core.world.scene.reading.xml import Element


class Actuators(NamedTuple):
    """The drives and controllers that a ``<plugin>`` of a model stands for."""

    drives: tuple[MountedDrive, ...] = ()
    controllers: tuple[JointController, ...] = ()
    trajectory_controllers: tuple[TrajectoryController, ...] = ()


class DriveReader(Protocol):
    """The class of a drive as readers use it, a :class:`nrp_core.world.drives.drive.Drive`."""

    def read_plugin(self, plugin: Element, model: ModelParts, reading: Reading) -> MountedDrive:
        """Read a ``<plugin>`` of a model."""


ControllerReader = Callable[[Element, ModelParts, Reading], Actuators | None]
"""Reads a ``<plugin>`` of a model; None where the plugin does nothing."""

DRIVES: Registry[DriveReader] = Registry("nrp_core.drives", "drive")
"""Drives by the names of the plugins that they read."""
CONTROLLERS: Registry[ControllerReader] = Registry("nrp_core.controllers", "reader of controllers")
"""Readers of controllers by the names of plugins."""


def read_actuators(plugin: Element, model: ModelParts, reading: Reading) -> Actuators | None:
    """Return the drives and controllers that a ``<plugin>`` stands for; None if it is of another kind."""
    drive = registered(DRIVES, plugin_name(plugin), plugin)
    if drive is not None:
        return Actuators((drive.read_plugin(plugin, model, reading),))
    controllers = registered(CONTROLLERS, plugin_name(plugin), plugin)
    return None if controllers is None else controllers(plugin, model, reading)
