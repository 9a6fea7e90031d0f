"""The pose of the camera for each image of a drawn video."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack
from itertools import product
from math import atan2, exp, hypot, inf, radians, tan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import from_seconds, seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.messages.foxglove_msgs import SceneUpdate
from nrp_core.recording.figures.room import Bounds, RoomView, footprint
from nrp_core.recording.figures.story import Story
from nrp_core.recording.images import Pixels, pixels_of
from nrp_core.recording.layout import MUSCLES, WORLD_FRAME, Role
from nrp_core.recording.reading.playback import Playback
from nrp_core.recording.reading.reader import RecordingReader
from nrp_core.recording.reading.shapes import RecordedScene, RecordedShape, ShapeKind
from nrp_core.recording.video import Renderer, Vector, VideoOptions, ViewKind
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.meshes.stl import write_coordinates
from nrp_core.scene.model import (
    Box,
    Cylinder,
    Geometry,
    Inertial,
    Light,
    Link,
    Mesh,
    Model,
    Rgba,
    Sphere,
    Texture,
    Visual,
)
from nrp_core.scene.rigid import Pose, matrix_of
from nrp_core.world.model_states import pose_of, transform_pose
from nrp_core.world.render.portrait import eye_that_sees
from nrp_core.world.render.realistic import LitView
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.render.shaded import ShadedView, sun_of
from nrp_core.world.render.tubes import Tubes


def camera_frames(recording: RecordingReader, times_s: FloatArray, options: VideoOptions) -> Iterator[Pixels]:
    """Yield the latest image of a camera at each time; before its first image, the first one.

    Raises:
        ExperimentError: the recording has no images of this camera.
    """
    images = recording.messages({_topic(recording, str(options.camera))})
    shown = next(images, None)
    if shown is None:
        raise ExperimentError(f"no images of '{options.camera}'", path=recording.file)
    coming = next(images, None)
    pixels = pixels_of(shown.message)
    for t_s in times_s.tolist():
        latest = None
        while coming is not None and seconds(coming.t_ns) <= t_s:
            latest, coming = coming, next(images, None)
        if latest is not None:
            pixels = pixels_of(latest.message)
        yield pixels


def camera_names(recording: RecordingReader) -> list[str]:
    """Return the topics of the cameras, and the parts of their names."""
    topics = [topic.name for topic in recording.with_role(Role.CAMERA)]
    return [*topics, *sorted({part for topic in topics for part in topic.split("/") if part})]


def _topic(recording: RecordingReader, camera: str) -> str:
    """Return the topic of a camera, by the topic or a part of its name."""
    topics = [topic.name for topic in recording.with_role(Role.CAMERA)]
    if camera in topics:
        return camera
    named = [topic for topic in topics if camera in topic.split("/")]
    if len(named) == 1:
        return named[0]
    if not topics:
        raise ExperimentError("the recording has no images of cameras", path=recording.file)
    wrong = f"several cameras are named '{camera}': {', '.join(named)}" if named else f"no camera '{camera}'"
    hint = "" if named else did_you_mean(camera, camera_names(recording))
    raise ExperimentError(wrong + hint, path=recording.file)


class RecordedMuscles:
    """The muscles after the messages on ``/scene/muscles``.

    Attributes:
        tubes: the tubes that they are drawn as.
        frames: the frames of the tubes.
        colors: the colours of their visuals.
    """

    def __init__(self) -> None:
        self._shapes: tuple[tuple[int, float], ...] = ()
        self.tubes = Tubes((), ())
        self.frames: dict[str, FloatArray] = {}
        self.colors: dict[str, Rgba] = {}

    def take(self, message: SceneUpdate) -> bool:
        """Apply a message; return whether the tubes changed."""
        lines = [line for entity in message.entities for line in entity.lines]
        before, self._shapes = self._shapes, tuple((len(line.points), line.thickness / 2) for line in lines)
        changed = self._shapes != before
        if changed:
            self.tubes = Tubes([count for count, _ in self._shapes], [radius for _, radius in self._shapes])
        paths = [np.array([(each.x, each.y, each.z) for each in line.points]) for line in lines]
        self.frames, self.colors = self.tubes.frames(paths), {}
        for number, line in enumerate(lines):
            color = line.color
            rgba = color.r, color.g, color.b, color.a
            self.colors.update(dict.fromkeys(self.tubes.visuals(number), rgba))
        return changed


class Stage:
    """The triangles of shapes, by the frames that they move with.

    Args:
        shapes: the shapes of the scene.
        kept: keeps the folder of the meshes, which are read when they are first drawn.
        muscles: the muscles at the time of an image, if any.

    Attributes:
        bodies: the bodies of each frame, and of the muscles.
        mesh: the triangles.
    """

    def __init__(
        self, shapes: Sequence[RecordedShape], kept: ExitStack, muscles: RecordedMuscles | None = None
    ) -> None:
        folder = Path(kept.enter_context(TemporaryDirectory()))
        names = dict.fromkeys(shape.frame for shape in shapes)
        models = [_model(name, [shape for shape in shapes if shape.frame == name], folder) for name in names]
        self._muscles = muscles = muscles or RecordedMuscles()
        self.bodies = bodies = {m.name: bodies_of(m) for m in (*models, *muscles.tubes.models)}
        numbers = frames_of(bodies)
        self.mesh = SceneMesh(bodies, numbers)
        self._numbers = {name: number for (name, _), number in numbers.items()}
        self._frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))

    def frames(self, poses: Mapping[str, Pose]) -> FloatArray:
        """Return all frames, the world's first, shape ``(n, 3, 4)``; frames without a pose do not move."""
        for visual, rgba in self._muscles.colors.items():
            self.mesh.set_color(visual, rgba)
        for name, number in self._numbers.items():
            if name in poses:
                self._frames[number] = matrix_of(poses[name])
        for name, frame in self._muscles.frames.items():
            self._frames[self._numbers[name]] = frame
        return self._frames


def _model(frame: str, shapes: Sequence[RecordedShape], folder: Path) -> Model:
    visuals = tuple(
        Visual(f"{number}", _geometry(shape, folder), shape.pose, shape.rgba, texture=_texture(shape, folder))
        for number, shape in enumerate(shapes)
        if shape.kind is not ShapeKind.MESH or shape.mesh is not None
    )
    link = Link("shapes", visuals=visuals, inertial=Inertial(1.0))
    return Model(frame, (link,), static=frame == WORLD_FRAME)


def _geometry(shape: RecordedShape, folder: Path) -> Geometry:
    x, y, z = shape.size
    match shape.kind:
        case ShapeKind.BOX:
            return Box((x, y, z))
        case ShapeKind.ELLIPSOID:
            return Sphere(x / 2)
        case ShapeKind.CYLINDER:
            return Cylinder(x / 2, z)
        case ShapeKind.MESH:
            assert shape.mesh is not None
            places = shape.image.coordinates if shape.image else None
            data = shape.mesh.tobytes()
            path = folder / f"{abs(hash((data, places if places is None else places.tobytes())))}.stl"
            if not path.exists():
                path.write_bytes(data)
                if places is not None:
                    write_coordinates(path, places)
            return Mesh(path, shape.size)


def _texture(shape: RecordedShape, folder: Path) -> Texture | None:
    if shape.image is None:
        return None
    path = folder / f"{abs(hash(shape.image.data))}.image"
    path.write_bytes(shape.image.data)
    return Texture(path, shape.image.tint)


FIELD_OF_VIEW = radians(45)
_DISTANCE, _UNKNOWN_M = 2.6, 0.5
"""The distance of the following camera, in multiples of the robot's size; that of a robot without shapes."""
_HEIGHTS = tuple(radians(degrees) for degrees in (27, 40, 55, 70, 88))
"""Angles above the horizon that it tries."""
_LAG_S = 0.6
"""Time constant of its rotation, s, so that quick turns of a robot do not shake the image."""
_OBLIQUE = (-1.0, -1.0, 0.9)
"""Direction from the middle of the scene to a free camera."""
_FILLED = 0.85
"""The share of the image of a free camera that robots and trajectories may cover."""


class Viewpoint(ABC):
    """Returns the pose of the camera."""

    @abstractmethod
    def eye(self, t_s: float, poses: Mapping[str, Pose]) -> FloatArray:
        """Return rotation and translation of the camera to the world, shape ``(3, 4)``."""


def look_at(
    eye: Vector | FloatArray, target: Vector | FloatArray, ahead: Vector = (0.0, 1.0, 0.0)
) -> FloatArray:
    """Return the pose of a camera that looks at a point, upright.

    Args:
        eye: its position, m.
        target: the point that it looks at, m.
        ahead: the direction that is up in the image if the camera looks straight down.
    """
    back = np.subtract(eye, target).astype(float)
    back /= max(float(np.linalg.norm(back)), 1e-9)
    up = np.array((0.0, 0.0, 1.0) if np.hypot(*back[:2]) > 1e-6 else ahead)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back, np.asarray(eye, float)])


class Still(Viewpoint):
    """A fixed camera."""

    def __init__(self, pose: FloatArray) -> None:
        self._pose = pose

    def eye(self, t_s: float, poses: Mapping[str, Pose]) -> FloatArray:
        return self._pose


def from_above(bounds: Bounds, aspect: float) -> Viewpoint:
    """Return a camera that looks down and sees the bounds on the ground.

    Args:
        bounds: the area that it must see.
        aspect: width of the image divided by its height.
    """
    seen = bounds.widened(aspect)
    middle = ((seen.left + seen.right) / 2, (seen.bottom + seen.top) / 2, 0.0)
    height = (seen.top - seen.bottom) / 2 / tan(FIELD_OF_VIEW / 2)
    return Still(look_at((middle[0], middle[1], height), middle))


def free(bounds: Bounds, top_m: float, aspect: float, eye: Vector | None, target: Vector | None) -> Viewpoint:
    """Return a fixed camera; by default it sees the bounds, up to a height, from a corner."""
    middle = target or ((bounds.left + bounds.right) / 2, (bounds.bottom + bounds.top) / 2, 0.0)
    if eye or target:
        away = max(bounds.right - bounds.left, bounds.top - bounds.bottom)
        return Still(look_at(eye or tuple(np.add(middle, np.multiply(_OBLIQUE, away))), middle))
    sides = (bounds.left, bounds.right), (bounds.bottom, bounds.top), (0.0, top_m)
    corners = np.array(list(product(*sides)), float)
    yaw, up = atan2(_OBLIQUE[1], _OBLIQUE[0]), atan2(_OBLIQUE[2], hypot(*_OBLIQUE[:2]))
    lens = {"vertical_fov": FIELD_OF_VIEW, "aspect": aspect, "filled": _FILLED}
    return Still(eye_that_sees(corners, yaw, up, **lens))


class Follower(Viewpoint):
    """A camera behind a robot that turns with it, and rises if something hides the robot.

    Args:
        frame: the frame of the robot's base.
        size_m: size of the robot; 0 if it is unknown.
        obstacles: boxes along the axes of the world that may hide it: lowest and highest corners, m, shape
            ``(n, 2, 3)``.
        middle: the middle of the robot in its base, m.
    """

    def __init__(
        self, frame: str, size_m: float, obstacles: FloatArray, middle: Vector = (0.0, 0.0, 0.0)
    ) -> None:
        self._frame, self._distance = frame, _DISTANCE * (size_m or _UNKNOWN_M)
        self._middle = Pose(middle)
        self._obstacles = obstacles
        self._way: FloatArray | None = None
        self._at_s = 0.0

    def eye(self, t_s: float, poses: Mapping[str, Pose]) -> FloatArray:
        pose = poses[self._frame]
        robot = np.array((pose @ self._middle).position)
        way = self._free_way(robot, pose.yaw)
        if self._way is not None:
            kept = exp(-max(t_s - self._at_s, 0.0) / _LAG_S)
            way = kept * self._way + (1 - kept) * way
        self._way, self._at_s = way, t_s
        way = way / max(float(np.linalg.norm(way)), 1e-9)
        ahead = (float(np.cos(pose.yaw)), float(np.sin(pose.yaw)), 0.0)
        return look_at(robot + self._distance * way, robot, ahead)

    def _free_way(self, robot: FloatArray, yaw: float) -> FloatArray:
        """Return the direction to the lowest camera behind the robot with a free view of it."""
        for height in _HEIGHTS:
            level = -np.cos(height)
            way = np.array((level * np.cos(yaw), level * np.sin(yaw), np.sin(height)))
            if not _is_hidden(robot, robot + self._distance * way, self._obstacles):
                break
        return way


def _is_hidden(start: FloatArray, end: FloatArray, boxes: FloatArray) -> bool:
    """Return whether a straight line meets a box that does not contain its start."""
    way = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = (boxes - start) / np.where(way == 0.0, 1e-12, way)
    enters, leaves = shares.min(axis=1).max(axis=1), shares.max(axis=1).min(axis=1)
    return bool(np.any((enters <= leaves) & (enters > 0.0) & (enters < 1.0)))


_SAMPLES = 2


def drawn_frames(recording: RecordingReader, times_s: FloatArray, options: VideoOptions) -> Iterator[Pixels]:
    """Yield images of the scene at some times, from the place in the options.

    Raises:
        ExperimentError: the recording has no scene, or the robot to follow is not in it.
    """
    viewpoint = _viewpoint(recording, options)
    topics = {
        topic.name for topic in recording.with_role(Role.SCENE, Role.TRANSFORMS, Role.MODELS, Role.MUSCLES)
    }
    playback, scene, poses = Playback(recording, topics), RecordedScene(), dict[str, Pose]()
    muscles = RecordedMuscles()
    draw: Draw | None = None
    with ExitStack() as kept:
        for t_s in times_s.tolist():
            changed = _follow(playback, from_seconds(t_s), scene, poses, muscles)
            if changed or draw is None:
                kept.close()
                stage = Stage(_visible_shapes(scene, options.view), kept, muscles)
                draw = _drawer(stage, muscles, recording, options)
            yield draw(poses, viewpoint.eye(t_s, poses))


Draw = Callable[[Mapping[str, Pose], FloatArray], Pixels]
"""Draws poses from the pose of an eye."""


def _drawer(
    stage: Stage, muscles: RecordedMuscles, recording: RecordingReader, options: VideoOptions
) -> Draw:
    size = options.width, options.height
    lights = recorded_lights(recording.run)
    if options.renderer is Renderer.SHADED:
        view = ShadedView(stage.mesh, *size, vertical_fov=FIELD_OF_VIEW, samples=_SAMPLES, sun=sun_of(lights))
        return lambda poses, eye: view.draw(stage.frames(poses), eye)
    lights = lights or [Light("sun", direction=_SUN)]
    lit = LitView(stage.bodies, lights, *size, vertical_fov=FIELD_OF_VIEW, samples=_SAMPLES)

    def draw(poses: Mapping[str, Pose], eye: FloatArray) -> Pixels:
        for visual, rgba in muscles.colors.items():
            lit.set_color(visual, rgba)
        return lit.draw(stage.frames(poses)[1:], eye)

    return draw


_SUN = (-0.4, 0.3, -0.9)
"""The direction of the light in a recording without one."""


def recorded_lights(run: Mapping[str, Any]) -> list[Light]:
    """Return the lights of a recording; it has the range and the outer cone of each."""
    found = (run.get("world") or {}).get("lights") or ()
    return [
        Light(
            f"light {number}", one["kind"], Pose(tuple(one["position"])), tuple(one["direction"]),
            (*one["color"], 1.0), one["casts_shadows"],
            (one["range_m"] or inf, *one["attenuation"]), (one["cone_rad"] / 2, one["cone_rad"]),
        )
        for number, one in enumerate(found)
    ]  # fmt: skip


def _follow(
    playback: Playback, t_ns: int, scene: RecordedScene, poses: dict[str, Pose], muscles: RecordedMuscles
) -> bool:
    """Update scene and poses to a time; return whether the scene changed."""
    changed = False
    for recorded in playback.until(t_ns):
        message = recorded.message
        if hasattr(message, "transforms"):
            poses |= {each.child_frame_id: transform_pose(each.transform) for each in message.transforms}
        elif hasattr(message, "pose"):
            poses |= {name: pose_of(pose) for name, pose in zip(message.name, message.pose, strict=True)}
        elif recorded.topic == MUSCLES:
            changed = muscles.take(message) or changed
        else:
            changed = bool(scene.take(message)) or changed
    return changed


def _visible_shapes(scene: RecordedScene, view: ViewKind) -> list[RecordedShape]:
    """Return the shapes to draw, without overhead ones, which would hide the scene from above."""
    seen = [shape for shape in scene.shapes if shape.rgba[3] > 0]
    if view is not ViewKind.ABOVE:
        return seen
    return [s for s in seen if s.frame != WORLD_FRAME or not footprint(s, Pose()).is_overhead]


def _viewpoint(recording: RecordingReader, options: VideoOptions) -> Viewpoint:
    story = Story.of(recording, options.begin_s, options.end_s)
    if not story.scene.shapes:
        raise ExperimentError("the recording has no scene", path=recording.file)
    bounds = RoomView.of(story).focus(story.coloured())
    match options.view:
        case ViewKind.ABOVE:
            return from_above(bounds, options.width / options.height)
        case ViewKind.FREE:
            box = _box(story, story.tracks)
            top_m = 0.0 if box is None else float(box[1][2])
            return free(bounds, top_m, options.width / options.height, options.eye, options.target)
        case ViewKind.FOLLOW:
            return _follower(story, options.robot, recording)


def _follower(story: Story, robot: str | None, recording: RecordingReader) -> Viewpoint:
    settings = dict(recording.run.get("settings") or {})
    names, robots = list(story.tracks), dict(settings.get("world") or {}).get("robots") or {}
    moved = sorted(names, key=lambda name: (name not in robots, -_way(story, name)))
    if not moved or (robot is not None and robot not in names):
        wrong = (
            "no model moves" if not moved else f"no model '{robot}' moves{did_you_mean(str(robot), names)}"
        )
        raise ExperimentError(wrong, path=recording.file)
    name = robot or moved[0]
    frames = [frame for frame in story.first_poses if frame.partition("/")[0] == name]
    base = min(frames, key=lambda frame: (frame == name, frames.index(frame)))
    box = _box(story, {name})
    if box is None:
        return Follower(base, 0.0, _obstacles(story))
    low, high = box
    x, y, z = ((low + high) / 2).tolist()
    middle = story.first_poses[base].inverse() @ Pose((x, y, z))
    return Follower(base, float((high - low).max()), _obstacles(story), middle.position)


def _obstacles(story: Story) -> FloatArray:
    """Return the bounding boxes of objects in the room: lowest and highest corners, shape ``(n, 2, 3)``."""
    fixed = (footprint(s, Pose()) for s in story.scene.shapes if s.frame == WORLD_FRAME and s.rgba[3] > 0)
    boxes = [
        ((*piece.outline.min(axis=0), piece.bottom), (*piece.outline.max(axis=0), piece.top))
        for piece in fixed
        if not piece.is_ground
    ]
    return np.array(boxes, float).reshape(-1, 2, 3)


def _way(story: Story, name: str) -> float:
    track = story.tracks[name]
    return float(np.hypot(np.diff(track.xs), np.diff(track.ys)).sum())


def _box(story: Story, names: Collection[str]) -> tuple[FloatArray, FloatArray] | None:
    """Return the lowest and highest corner (m) of robots at their first poses; None without shapes."""
    poses = story.first_poses
    pieces = [
        footprint(s, poses[s.frame]) for s in story.scene.shapes if s.model in names and s.frame in poses
    ]
    if not pieces:
        return None
    outline = np.concatenate([piece.outline for piece in pieces])
    low, high = min(piece.bottom for piece in pieces), max(piece.top for piece in pieces)
    return np.append(outline.min(axis=0), low), np.append(outline.max(axis=0), high)
