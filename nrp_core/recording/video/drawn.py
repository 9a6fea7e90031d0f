"""Draw a recorded scene, image by image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import from_seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.figures.story import Story
from nrp_core.recording.figures.view import RoomView, footprint
from nrp_core.recording.images import Pixels
from nrp_core.recording.layout import WORLD_FRAME, Role
from nrp_core.recording.reading.playback import Playback
from nrp_core.recording.reading.recording import Recording
from nrp_core.recording.reading.shapes import RecordedScene, Shape
from nrp_core.recording.video import VideoOptions, View
from nrp_core.recording.video.stage import Stage
from nrp_core.recording.video.views import FIELD_OF_VIEW, Follower, Viewpoint, free, from_above
from nrp_core.world.model_states import pose_of, transform_pose
from nrp_core.world.render.portrait import ShadedView
from nrp_core.world.rigid import Pose

_SAMPLES = 2


def drawn_frames(recording: Recording, times_s: FloatArray, options: VideoOptions) -> Iterator[Pixels]:
    """Yield images of the scene at some times, from the place in the options.

    Raises:
        ExperimentError: the recording has no scene, or the robot to follow is not in it.
    """
    viewpoint = _viewpoint(recording, options)
    topics = {topic.name for topic in recording.with_role(Role.SCENE, Role.TRANSFORMS, Role.MODELS)}
    playback, scene, poses = Playback(recording, topics), RecordedScene(), dict[str, Pose]()
    with ExitStack() as kept:
        view: ShadedView | None = None
        for t_s in times_s.tolist():
            changed = _follow(playback, from_seconds(t_s), scene, poses)
            if changed or view is None:
                kept.close()
                stage = Stage(_seen(scene, options.view), kept)
                size = (options.width, options.height)
                view = ShadedView(stage.mesh, *size, vertical_fov=FIELD_OF_VIEW, samples=_SAMPLES)
            yield view.draw(stage.vertices(poses), viewpoint.eye(t_s, poses))


def _follow(playback: Playback, t_ns: int, scene: RecordedScene, poses: dict[str, Pose]) -> bool:
    """Update scene and poses to a time; return whether the scene changed."""
    changed = False
    for recorded in playback.until(t_ns):
        message = recorded.message
        if hasattr(message, "transforms"):
            poses |= {each.child_frame_id: transform_pose(each.transform) for each in message.transforms}
        elif hasattr(message, "pose"):
            poses |= {name: pose_of(pose) for name, pose in zip(message.name, message.pose, strict=True)}
        else:
            changed = bool(scene.take(message)) or changed
    return changed


def _seen(scene: RecordedScene, view: View) -> list[Shape]:
    """Return the shapes to draw, without overhead ones, which would hide the scene from above."""
    seen = [shape for shape in scene.shapes if shape.rgba[3] > 0]
    if view is not View.ABOVE:
        return seen
    return [s for s in seen if s.frame != WORLD_FRAME or not footprint(s, Pose()).is_overhead]


def _viewpoint(recording: Recording, options: VideoOptions) -> Viewpoint:
    story = Story.of(recording, options.begin_s, options.end_s)
    if not story.scene.shapes:
        raise ExperimentError("the recording has no scene", path=recording.file)
    bounds = RoomView.of(story).focus(story.coloured())
    match options.view:
        case View.ABOVE:
            return from_above(bounds, options.width / options.height)
        case View.FREE:
            return free(bounds, options.eye, options.target)
        case View.FOLLOW:
            return _follower(story, options.robot, recording)


def _follower(story: Story, robot: str | None, recording: Recording) -> Viewpoint:
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
    return Follower(base, _size(story, name, story.first_poses), _obstacles(story))


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


def _size(story: Story, name: str, poses: Mapping[str, Pose]) -> float:
    """Return the larger side of a robot as seen from above, m."""
    shapes = [s for s in story.scene.shapes if s.model == name and s.frame in poses]
    if not shapes:
        return 0.0
    outline = np.concatenate([footprint(shape, poses[shape.frame]).outline for shape in shapes])
    return float(np.ptp(outline, axis=0).max())
