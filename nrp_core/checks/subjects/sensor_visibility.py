"""Scanners and cameras that see only their own robot at the start, or a scene without light."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.checks.examined import ExaminedExperiment, checks_experiment
from nrp_core.checks.subjects.time_conditions import read_topics
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding
from nrp_core.scene.devices import MountedSensor, View
from nrp_core.scene.merged_bodies import Body, bodies_of
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.posture import body_poses
from nrp_core.scene.rigid import BodyPath, ReadFrames, matrix_of
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.raycast.collisions import CollisionSpace
from nrp_core.world.render.cameras import CameraPath, Optics
from nrp_core.world.render.raster import RasterCameras

COVERED: Final = 0.9
"""Share of rays on the own robot of a sensor that sees only that; cameras above a gripper reach a half."""
COLUMNS: Final = 16
MAX_ROWS: Final = 64
"""Size of an image whose pixels are only counted."""

_Frames = Callable[[Sequence[BodyPath]], ReadFrames]


@dataclass(frozen=True, slots=True)
class OwnRobotView:
    """The part of a sensor's view that shows its own robot.

    Args:
        link: the link that carries the sensor.
        sensor: the sensor.
        share: the share of its rays that end on its own robot.
        nearest_m: the length of the shortest of these rays; infinite without any.
    """

    link: str
    sensor: MountedSensor
    share: float
    nearest_m: float


@checks_experiment
def check_own_robot_views(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report scanners and cameras that are read and see only their own robot."""
    read = {id(sensor): model.name for model, sensor in read_sensors(examined)}
    for model in examined.robots:
        if examined.scene is None or model.name not in read.values():
            continue
        with suppress(SceneError):  # a mesh cannot be read, which the reader reports
            for view in own_robot_views(examined.scene, model):
                if view.share >= COVERED and id(view.sensor) in read:
                    kind, rays = ("camera", "pixels") if view.sensor.views else ("scanner", "beams")
                    message = (
                        f"the {kind} '{view.sensor.name}' on '{model.name}/{view.link}' sees its own robot "
                        f"with {view.share:.0%} of its {rays}, from {view.nearest_m:.2g} m"
                    )
                    yield examined.warning(Code.NRP374, message, "world", "robots", model.name)


def read_sensors(examined: ExaminedExperiment) -> Iterator[tuple[Model, MountedSensor]]:
    """Yield the scanners and cameras of robots that are read, or that the experiment adds for recordings."""
    read = read_topics(examined)
    for model in examined.robots:
        added = {one.name or one.type for one in examined.experiment.world.robots[model.name].add_sensors}
        for sensor in (sensor for link in model.links for sensor in link.sensors):
            sees = sensor.views or isinstance(getattr(sensor, "beams", None), Beams)
            if sees and (sensor.name in added or not read.isdisjoint(sensor.topics)):
                yield model, sensor


def own_robot_views(scene: Scene, model: Model) -> Iterator[OwnRobotView]:
    """Yield how much each scanner and camera of a model sees of the model itself at the start.

    A ray ends on its own robot if it has the same length in a scene with this robot alone.

    Raises:
        SceneError: a mesh cannot be read.
    """
    everything = {one.name: bodies_of(one) for one in scene.models}
    alone = {model.name: everything[model.name]}
    read = _frames_at_start(scene, everything)
    views: dict[CameraPath, View] = {
        (model.name, link.name, name): view
        for link in model.links
        for sensor in link.sensors
        for name, view in sensor.views.items()
    }
    cameras = [_coarse_cameras(bodies, views, read) for bodies in (everything, alone)] if views else []
    for link in model.links:
        for sensor in link.sensors:
            beams = getattr(sensor, "beams", None)
            if isinstance(beams, Beams):
                far = replace(beams, reach=(beams.reach[0], inf))
                spaces = (CollisionSpace(bodies, read) for bodies in (everything, alone))
                lengths_m, own_m = (one.scan(model.name, link.name, far) for one in spaces)
            elif sensor.views:
                paths = [(model.name, link.name, name) for name in sensor.views]
                lengths_m, own_m = (
                    np.concatenate([one.depth(path).ravel() for path in paths]) for one in cameras
                )
            else:
                continue
            is_own = np.isfinite(own_m) & (own_m > 0.0) & (own_m <= lengths_m)
            yield OwnRobotView(link.name, sensor, float(is_own.mean()), float(own_m[is_own].min(initial=inf)))


def _frames_at_start(scene: Scene, bodies: Mapping[str, Sequence[Body]]) -> _Frames:
    poses = {model.name: body_poses(model, bodies[model.name]) for model in scene.models}

    def reader(paths: Sequence[BodyPath]) -> ReadFrames:
        def read(frames: FloatArray) -> None:
            for i, (name, index) in enumerate(paths):
                frames[i] = matrix_of(poses[name][index])

        return read

    return reader


def _coarse_cameras(
    bodies: Mapping[str, Sequence[Body]], views: Mapping[CameraPath, View], read: _Frames
) -> RasterCameras:
    """Return cameras with few pixels."""
    optics = {}
    for path, view in views.items():
        n_rows = max(1, min(MAX_ROWS, round(COLUMNS * view.height / view.width)))
        optics[path] = Optics.of(replace(view, width=COLUMNS, height=n_rows), 1.0)
    return RasterCameras(bodies, optics, read)
