"""Robots and rooms in SDF 1.4 to 1.12, the format of Gazebo, and robots in URDF, which is read as SDF.

Defaults are those of the specification (http://sdformat.org/spec), with two exceptions that real files need:
a link without ``<inertial>`` has the mass of its collision shapes at the density of water (SDF: 1 kg), and a
revolute joint without limits is continuous.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from math import hypot
from pathlib import Path
from types import MappingProxyType
from typing import Final

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.paths import path_of
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.reading.context import Element, FindElsewhere, Notes, Places, Reading, Resources
from nrp_core.scene.reading.unread import report_unread
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf.frames import pass_over_room, read_placed, without_surroundings
from nrp_core.scene.sdf.model import build_model, read_parts
from nrp_core.scene.sdf.source import SdfFile
from nrp_core.scene.sdf.world import read_world
from nrp_core.scene.stand_in import with_static_shapes

__all__ = ["read_model", "read_scene"]

_ON_EARTH: Final = (-9.9, -9.7)
"""Gravity on Earth as files round it, m/s^2."""
_ASIDE: Final = 0.1


@checks_arguments()
def read_model(
    path: Path | str,
    *,
    name: str | None = None,
    pose: Pose | None = None,
    search_path: Iterable[Path | str] = (),
    without: Places = MappingProxyType({}),
    lenient: bool = False,
    args: Mapping[str, object] = MappingProxyType({}),
    find_elsewhere: FindElsewhere | None = None,
) -> Model:
    """Read a file that holds one model.

    Args:
        path: the file.
        name: the name of the model in the scene, a robot's id; by default the name in the file. Relative
            topics of the file resolve below it.
        pose: its pose in the world; by default the pose in the file.
        search_path: folders in which ``model://`` and relative paths are searched.
        without: the elements to leave out; see :mod:`nrp_core.scene.reading.context`.
        lenient: whether to omit missing included files, with a warning instead of an error.
        args: arguments of a xacro file; others have their defaults.
        find_elsewhere: called with the name of a mesh or an image that is not found, returns it or None.

    Raises:
        SceneError: the file cannot be used; the message names file and line.
    """
    resources = Resources(search_path, find_elsewhere)
    reading = Reading(resources, Notes(), without=without, lenient=lenient, args=args)
    source = SdfFile.open(path_of(path, SceneError), reading)
    holder = source.root.find("world") or source.root
    _warn_of_gravity(holder, reading)
    models = without_surroundings(read_placed(holder, source, reading, "model"), reading)
    if len(models) != 1:
        odd = models[1].user if models else source.root
        raise odd.error(f"a robot's file must hold one <model>; this one holds {len(models)}")
    (placed,) = models
    own = replace(reading, robot=name or placed.name)
    parts = read_parts(placed, own, static=placed.static)
    for each in (placed.element, placed.user):
        each.pass_over("pose", "placement_frame")  # which another pose may replace
    stands = pose or placed.pose(WORLD, parts.frames)[0]
    (model,) = with_static_shapes(
        [build_model(placed, parts, own.robot, stands, own)], partial(reading.notes.warn, placed.element)
    )
    pass_over_room(source.root)
    report_unread(reading)
    return replace(model, warnings=reading.notes.findings)


def _warn_of_gravity(holder: Element, reading: Reading) -> None:
    """Warn of a gravity in the file of a robot that differs from Earth's, because it is unused."""
    gravity = holder.find("gravity") if holder.tag == "world" else None
    if gravity is not None:
        x, y, z = gravity.numbers(3)
        if hypot(x, y) > _ASIDE or not _ON_EARTH[0] <= z <= _ON_EARTH[1]:
            message = f"the gravity of {gravity.text} in the file of a robot is not used: that of the room is"
            reading.notes.warn(gravity, Code.NRP383, message, subject="gravity")


@checks_arguments()
def read_scene(
    path: Path | str,
    *,
    search_path: Iterable[Path | str] = (),
    without: Places = MappingProxyType({}),
    lenient: bool = False,
    args: Mapping[str, object] = MappingProxyType({}),
    find_elsewhere: FindElsewhere | None = None,
) -> Scene:
    """Read a file that holds a world, or models without one.

    Args:
        path: the file.
        search_path: folders in which ``model://`` and relative paths are searched.
        without: the elements to leave out; see :mod:`nrp_core.scene.reading.context`.
        lenient: whether to omit missing included files, with a warning instead of an error.
        args: arguments of a xacro file; others have their defaults.
        find_elsewhere: called with the name of a mesh or an image that is not found, returns it or None.

    Raises:
        SceneError: the file cannot be used; the message names file and line.
    """
    resources = Resources(search_path, find_elsewhere)
    reading = Reading(resources, Notes(), without=without, lenient=lenient, args=args)
    source = SdfFile.open(path_of(path, SceneError), reading)
    worlds = source.root.all("world")
    if len(worlds) > 1:
        raise worlds[1].error(f"a room's file must hold one <world>; this one holds {len(worlds)}")
    scene = read_world(worlds[0] if worlds else source.root, source, reading)
    report_unread(reading)
    return replace(scene, warnings=reading.notes.findings)
