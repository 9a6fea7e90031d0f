"""Find the drives and controllers of a file: each is read by the reader registered for its plugin."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple, Protocol

from nrp_core.registry import Registry
from nrp_core.world.scene.acting import (
    GroupController,
    JointController,
    MountedDrive,
    PairController,
    Rename,
    TrajectoryController,
)
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.registered import ModelParts, registered
from nrp_core.world.scene.reading.xml import Element


class Actuators(NamedTuple):
    """The drives and controllers that a ``<plugin>`` of a model declares."""

    drives: tuple[MountedDrive, ...] = ()
    controllers: tuple[JointController, ...] = ()
    trajectory_controllers: tuple[TrajectoryController, ...] = ()
    pair_controllers: tuple[PairController, ...] = ()
    group_controllers: tuple[GroupController, ...] = ()

    def with_others(self, others: Actuators) -> Actuators:
        """Return these and others; equal controllers of a joint are merged into the first one."""
        return Actuators(
            (*self.drives, *others.drives),
            _once((*self.controllers, *others.controllers)),
            (*self.trajectory_controllers, *others.trajectory_controllers),
            (*self.pair_controllers, *others.pair_controllers),
            (*self.group_controllers, *others.group_controllers),
        )

    def renamed(self, named: Rename) -> Actuators:
        """Return the same actuators for a model whose parts are renamed."""
        return Actuators(
            tuple(drive.renamed(named) for drive in self.drives),
            tuple(controller.renamed(named) for controller in self.controllers),
            tuple(follower.renamed(named) for follower in self.trajectory_controllers),
            tuple(pair.renamed(named) for pair in self.pair_controllers),
            tuple(group.renamed(named) for group in self.group_controllers),
        )


def _once(controllers: Sequence[JointController]) -> tuple[JointController, ...]:
    """Return controllers without duplicates, which have the same joint, kind and topic."""
    found: dict[tuple[str, str, str], JointController] = {}
    for each in controllers:
        first = found.setdefault((each.joint, each.kind, each.topic), each)
        if first.initial is None and each.initial is not None:
            found[each.joint, each.kind, each.topic] = replace(first, initial=each.initial)
    return tuple(found.values())


class DriveReader(Protocol):
    """The class of a drive for readers, a :class:`nrp_core.world.drives.drive.Drive`."""

    def read_plugin(self, plugin: Element, model: ModelParts, reading: Reading) -> MountedDrive:
        """Read a ``<plugin>`` of a model."""


ControllerReader = Callable[[Element, ModelParts, Reading], Actuators | None]
"""Reads a ``<plugin>`` of a model; None if the plugin does nothing."""

DRIVES: Registry[DriveReader] = Registry("nrp_core.drives", "drive")
"""Drives by the names of the plugins that they read."""
CONTROLLERS: Registry[ControllerReader] = Registry("nrp_core.controllers", "reader of controllers")
"""Readers of controllers by the names of plugins."""


def read_actuators(plugin: Element, model: ModelParts, reading: Reading) -> Actuators | None:
    """Return the drives and controllers that a ``<plugin>`` declares; None if it declares neither."""
    drive = registered(DRIVES, plugin_name(plugin), plugin)
    if drive is not None:
        return Actuators((drive.read_plugin(plugin, model, reading),))
    controllers = registered(CONTROLLERS, plugin_name(plugin), plugin)
    return None if controllers is None else controllers(plugin, model, reading)
