"""The plugins of Gazebo itself that move wheels, and the drives of nrp-core that move them otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePath

from nrp_core.errors import SceneError
from nrp_core.world import Code, Finding, Level, Model
from nrp_core.world.engine_kit.planar_servo import PlanarDrive, planar_drives
from nrp_world_gazebo.elements import Xml

OWN = "libDiffDrivePlugin.so"
"""The drive among the plugins of Gazebo itself that names its joints; it reads ``~/MODEL/vel_cmd``."""


def turns_of(model: Model, own: Xml | None) -> Iterator[tuple[tuple[str, str], float]]:
    """Yield each drive of a model and the sign with which its plugin takes a turn to the left.

    Args:
        model: the model, whose drives must be plugins of Gazebo itself.
        own: its ``<sdf>`` as Gazebo reads it from its file; None if it does not.

    Raises:
        SceneError: a drive has no plugin that Gazebo runs.
    """
    for drive in planar_drives(model):
        found = [] if own is None else [_file(each) for each in own.iter("plugin") if _is(each, drive)]
        if found and found[0] == OWN:
            yield (model.name, drive.name), _turn(model, drive)
            continue
        kind = found[0] if found else "not in a file that Gazebo reads itself"
        raise SceneError(
            f"drive: plugin leaves drives to the plugin of Gazebo itself ({OWN}), but the drive "
            f"'{drive.name}' of '{model.name}' is {kind}; choose drive: planar or physical"
        )


def _turn(model: Model, drive: PlanarDrive) -> float:
    """Return the sign: by a positive yaw the plugin speeds up the wheel that it has as the left one."""
    aside = {joint.name: joint.pose.position[1] for joint in model.joints}
    left, right = drive.joints
    return -1.0 if aside[left] > aside[right] else 1.0


def leave_out(model: Model, own: Xml) -> Iterator[Finding]:
    """Take the plugins away whose drives nrp-core runs, and yield what others could disturb.

    Args:
        model: the model.
        own: its ``<sdf>``, which is changed.
    """
    for drive in planar_drives(model):
        for plugin in [each for each in own.iter("plugin") if _is(each, drive)]:
            plugin.getparent().remove(plugin)
            if _file(plugin) == OWN:
                message = (
                    f"the plugin '{drive.name}' ({_file(plugin)}) of '{model.name}' does not run, nrp-core's "
                    f"drive moves the robot instead; drive: plugin leaves it to Gazebo"
                )
                yield _finding(model, plugin, message, Level.NOTE)
    driven = {joint for drive in planar_drives(model) for joint in drive.joints}
    for plugin in own.iter("plugin"):
        shared = sorted(driven & {(each.text or "").strip() for each in plugin.iter()})
        if shared:
            message = (
                f"the plugin '{plugin.get('name')}' ({_file(plugin)}) of '{model.name}' names the joint "
                f"'{shared[0]}', which a drive of nrp-core moves: if the plugin moves it, too, both act"
            )
            yield _finding(model, plugin, message, Level.WARNING)


def _finding(model: Model, plugin: Xml, message: str, level: Level) -> Finding:
    file = model.source.file if model.source else None
    return Finding(Code.NRP376, message, level, file, plugin.sourceline, subject=plugin.get("name"))


def _is(plugin: Xml, drive: PlanarDrive) -> bool:
    return bool(plugin.get("name") == drive.name)


def _file(plugin: Xml) -> str:
    return PurePath(plugin.get("filename", "")).name
