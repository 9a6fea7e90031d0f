"""What scanners and cameras see at the start: what their rays and pixels end on, without an engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf, pi

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.enclosing import Enclosure, Placed, enclosures
from nrp_core.world.raycast.beams import Beams, directions
from nrp_core.world.raycast.collisions import CollisionSpace
from nrp_core.world.render.cameras import CameraPath, Optics
from nrp_core.world.render.raster import RasterCameras
from nrp_core.world.rigid import BodyPath, Pose, ReadFrames, matrix_of
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.devices import MountedSensor, View
from nrp_core.world.scene.merged_bodies import Body, bodies_of, body_of
from nrp_core.world.scene.model import Link, Model, Scene
from nrp_core.world.scene.posture import body_poses

_COLUMNS, _MOST_ROWS = 16, 64
"""Pixels of an image that is only counted."""
_HEADINGS = tuple(i * pi / 4 for i in range(1, 8))

Labels = npt.NDArray[np.int64]
"""Of each ray: 1 + the index of the link of its robot on which it ends; -1: on another model; 0: nowhere."""
_OTHER = 2**16 - 1
_Look = tuple[Labels, FloatArray]
"""The labels of rays, and their lengths, m."""


@dataclass(frozen=True, slots=True)
class Sight:
    """What a sensor sees.

    Args:
        link: the link that carries it.
        sensor: the sensor.
        own: share of its rays that end on its own robot, of the link that is hit most, and the name of this.
        nearest_m: length of the shortest ray that ends on its own robot.
        empty: share of rays that end nowhere, however long they are, at any heading of its robot.
        up: mean of the vertical parts of its rays, which are unit vectors.
        turns: whether a joint turns it.
        middle: share of the middle of an image, half as wide and high, that shows the rigid body that carries
            the camera; 0 for a scanner.
        middle_m: the shortest line of sight among them, m.
    """

    link: str
    sensor: MountedSensor
    own: float
    most: str
    nearest_m: float
    empty: float
    up: float
    turns: bool
    middle: float = 0.0
    middle_m: float = inf


def sights(scene: Scene, model: Model) -> Iterator[Sight]:
    """Yield what each scanner and camera of a model sees at the start.

    Raises:
        SceneError: a mesh cannot be read.
    """
    still = _Still(scene)
    bodies = still.bodies[model.name]
    views: dict[CameraPath, View] = {
        (model.name, link.name, name): view
        for link in model.links
        for sensor in link.sensors
        for name, view in sensor.views.items()
    }
    cameras = _cameras(still, model, views) if views else None
    numbers = {link.name: number for number, link in enumerate(model.links, start=1)}
    for link in model.links:
        for sensor in link.sensors:
            beams = getattr(sensor, "beams", None)
            if isinstance(beams, Beams):
                look = _scanner(model, link, beams, still)
                rays = directions(beams) @ matrix_of(beams.pose)[:, :3].T
            elif sensor.views and cameras is not None:
                look = _camera([(model.name, link.name, name) for name in sensor.views], cameras)
                rays = np.array([view.pose.rotate((1.0, 0.0, 0.0)) for view in sensor.views.values()])
            else:
                continue
            index = body_of(bodies, link.name)
            labels, lengths_m = look()
            held = [numbers[part.name] for part in bodies[index].links]
            mine = labels > 0
            counts = np.bincount(labels[mine], minlength=1)
            yield Sight(
                link.name, sensor, float(mine.mean()),
                model.links[int(counts.argmax()) - 1].name if mine.any() else "",
                float(lengths_m[mine].min(initial=inf)),
                _empty(labels, look, model, still),
                float((rays @ matrix_of(still.place(model, link))[2, :3]).mean()),
                bodies[index].parent is not None,
                *_middle(sensor, np.isin(labels, held), lengths_m),
            )  # fmt: skip


def _middle(sensor: MountedSensor, own: npt.NDArray[np.bool_], lengths_m: FloatArray) -> tuple[float, float]:
    """Return the share of the middle of an image that ends on own shapes, and the shortest line there, m."""
    if len(sensor.views) != 1:  # several views are the whole of what an eye sees around it
        return 0.0, inf
    rows, columns = len(own) // _COLUMNS, _COLUMNS
    cut = np.s_[rows // 4 : rows - rows // 4, columns // 4 : columns - columns // 4]
    covered, deep = own.reshape(rows, columns)[cut], lengths_m.reshape(rows, columns)[cut]
    return float(covered.mean()), float(deep[covered].min(initial=inf))


def enclosed(scene: Scene, model: Model) -> Iterator[tuple[str, MountedSensor, Enclosure]]:
    """Yield the cameras of a model that start inside a visible shape, with their links and the shape.

    Of several shapes it is the one in which the line of sight runs farthest, and a sensor of several views
    stands inside a shape if all of them do.

    Raises:
        SceneError: a mesh cannot be read.
    """
    still = _Still(scene)
    cameras = [(link, sensor) for link in model.links for sensor in link.sensors if sensor.views]
    if not cameras:
        return
    eyes = [still.place(model, link) @ view.pose for link, one in cameras for view in one.views.values()]
    shapes = [one for name in still.bodies for one in still.visuals(name)]
    around = iter(enclosures(eyes, shapes))
    for link, sensor in cameras:
        found = [next(around) for _ in sensor.views]
        if all(found):
            yield link.name, sensor, min((max(each, key=_through) for each in found), key=_through)


def _through(enclosure: Enclosure) -> float:
    return enclosure.through_m


class _Still:
    """The bodies of a scene where they start, one model turned about the vertical."""

    def __init__(self, scene: Scene) -> None:
        self.bodies = {model.name: bodies_of(model) for model in scene.models}
        self._models = {model.name: model for model in scene.models}
        self.heading: tuple[str, float] = "", 0.0

    def poses(self, name: str) -> list[Pose]:
        """Return the poses of a model's bodies in the world."""
        turned, angle = self.heading
        model = self._models[name]
        if turned == name:
            pose = model.pose
            turn = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, 0.0, angle) @ Pose(orientation=pose.orientation)
            model = replace(model, pose=Pose(pose.position, turn.orientation))
        return body_poses(model, self.bodies[name])

    def reader(self, paths: Sequence[BodyPath]) -> ReadFrames:
        """Return a function that writes the poses of bodies, as an engine does."""

        def read(frames: FloatArray) -> None:
            poses = {name: self.poses(name) for name in {name for name, _ in paths}}
            for i, (name, index) in enumerate(paths):
                frames[i] = matrix_of(poses[name][index])

        return read

    def place(self, model: Model, link: Link) -> Pose:
        """Return the pose of a link in the world."""
        index = body_of(self.bodies[model.name], link.name)
        body = self.bodies[model.name][index]
        held = next(part.pose for part in body.links if part.name == link.name)
        return (body.pose if body.fixed else self.poses(model.name)[index]) @ held

    def visuals(self, name: str) -> Iterator[Placed]:
        """Yield the visuals of a model."""
        for body, pose in zip(self.bodies[name], self.poses(name), strict=True):
            for link in body.links:
                for visual in link.visuals:
                    place = (body.pose if body.fixed else pose) @ link.pose @ visual.pose
                    yield Placed(name, link.name, visual, place)


def _empty(labels: Labels, look: Callable[[], _Look], model: Model, still: _Still) -> float:
    """Return the least share of rays that end nowhere, over the headings of a model that is not held."""
    least = float((labels == 0).mean())
    if model.static or any(joint.parent == WORLD for joint in model.joints):
        return least
    for angle in _HEADINGS:
        if least < 0.5:
            break
        still.heading = model.name, angle
        least = min(least, float((look()[0] == 0).mean()))
    still.heading = "", 0.0
    return least


def _scanner(model: Model, link: Link, beams: Beams, still: _Still) -> Callable[[], _Look]:
    """Return a function that casts the rays of a scanner, however far they reach."""
    far = replace(beams, reach=(beams.reach[0], inf))
    whole = CollisionSpace(still.bodies, still.reader)
    alone = [
        (number, CollisionSpace({model.name: _only(still.bodies[model.name], each.name)}, still.reader))
        for number, each in enumerate(model.links, start=1)
        if each.collisions
    ]

    def look() -> _Look:
        lengths_m = whole.scan(model.name, link.name, far)
        labels = np.where(np.isfinite(lengths_m), -1, 0)
        for number, space in alone:
            labels[np.isfinite(lengths_m) & (space.scan(model.name, link.name, far) <= lengths_m)] = number
        return labels, lengths_m

    return look


def _changed(bodies: Sequence[Body], change: Callable[[Link], Link]) -> list[Body]:
    return [replace(body, links=tuple(change(link) for link in body.links)) for body in bodies]


def _only(bodies: Sequence[Body], link: str) -> list[Body]:
    """Return bodies with the collision shapes of one link."""
    return _changed(bodies, lambda one: one if one.name == link else replace(one, collisions=()))


def _cameras(scene: _Still, model: Model, views: Mapping[CameraPath, View]) -> RasterCameras:
    """Return cameras whose segments are the numbers of the links of a model."""
    numbers = {link.name: number for number, link in enumerate(model.links, start=1)}

    def labelled(numbers: Mapping[str, int], link: Link) -> Link:
        label = numbers.get(link.name, _OTHER)
        return replace(link, visuals=tuple(replace(one, label=label, texture=None) for one in link.visuals))

    bodies = {
        name: _changed(each, partial(labelled, numbers if name == model.name else {}))
        for name, each in scene.bodies.items()
    }
    coarse = {path: replace(view, width=_COLUMNS, height=_rows(view)) for path, view in views.items()}
    return RasterCameras(bodies, {path: Optics.of(view, 1.0) for path, view in coarse.items()}, scene.reader)


def _rows(view: View) -> int:
    return max(1, min(_MOST_ROWS, round(_COLUMNS * view.height / view.width)))


def _camera(paths: Sequence[CameraPath], cameras: RasterCameras) -> Callable[[], _Look]:
    """Return a function that draws the views of a camera."""

    def look() -> _Look:
        seen = np.concatenate([cameras.segments(path)[..., 0].ravel() for path in paths]).astype(np.int64)
        lengths_m = np.concatenate([cameras.depth(path).ravel() for path in paths])
        seen[seen == _OTHER] = -1
        return seen, lengths_m.astype(float)

    return look
