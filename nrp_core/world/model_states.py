"""Poses and velocities of models and links as messages, and the colours of visuals."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from nrp_core.messages.gazebo_msgs import LinkStates, ModelStates
from nrp_core.messages.geometry_msgs import Point, Quaternion, Twist, Vector3
from nrp_core.messages.geometry_msgs import Pose as PoseMessage
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.model import Rgba, Scene
from nrp_core.scene.rigid import ModelMotion, Pose, Vector, multiply
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo


@lru_cache(maxsize=4096)
def _color_topics(visual: str) -> tuple[TopicInfo]:
    """Return the topic of the colour of a visual, which all copies of a scene share."""
    what = f"colour of the visual {visual}"
    return (TopicInfo(f"/{visual}/color", ColorRGBA, Direction.BOTH, what=what, limits=(0, 1)),)


class ColorPart(Part):
    """The topic ``/<model>/<link>/<visual>/color``, to read or set the colour."""

    def __init__(self, visual: str, rgba: Rgba, glows: bool, engine: Engine) -> None:
        self._visual, self._initial, self._engine = visual, (rgba, glows), engine
        self._rgba, self._glows = rgba, glows
        self.topics = _color_topics(visual)

    def read(self, topic: str, now_ns: int) -> ColorRGBA:
        return ColorRGBA(*self._rgba)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._set((float(message.r), float(message.g), float(message.b), float(message.a)))

    def set_glow(self, glows: bool) -> None:
        """Set whether the visual has its colour in any light."""
        self._glows = glows
        self._engine.set_glow(self._visual, glows)

    def reset(self) -> None:
        self.restore(self._initial)

    def save(self) -> object:
        return self._rgba, self._glows

    def restore(self, saved: Any) -> None:
        rgba, glows = saved
        self._set(rgba)
        if glows is not self._glows:
            self.set_glow(glows)

    def _set(self, rgba: Rgba) -> None:
        self._rgba = rgba
        self._engine.set_color(self._visual, rgba)


def pose_message(pose: Pose) -> PoseMessage:
    """Return a pose as a message."""
    return PoseMessage(Point(*pose.position), Quaternion(*pose.orientation))


def twist_message(linear: Vector, angular: Vector) -> Twist:
    """Return velocities as a message."""
    return Twist(Vector3(*linear), Vector3(*angular))


def state_messages(motion: ModelMotion) -> tuple[PoseMessage, Twist]:
    """Return pose and velocity of a motion as messages."""
    return pose_message(motion.pose), twist_message(motion.linear, motion.angular)


def pose_of(message: PoseMessage) -> Pose:
    """Return the pose in a message; an orientation of length 0 means no rotation, any other is normalised."""
    q, p = message.orientation, message.position
    turn = float(q.x), float(q.y), float(q.z), float(q.w)
    orientation = multiply((0.0, 0.0, 0.0, 1.0), turn) if any(turn) else (0.0, 0.0, 0.0, 1.0)
    return Pose((float(p.x), float(p.y), float(p.z)), orientation)


def transform_pose(message: Any) -> Pose:
    """Return a ``geometry_msgs/Transform`` as a pose."""
    return pose_of(PoseMessage(message.translation, message.rotation))


def vector_of(message: Vector3 | Point) -> Vector:
    """Return the velocities in a message."""
    return float(message.x), float(message.y), float(message.z)


def relative_motion(reference: ModelMotion, motion: ModelMotion) -> ModelMotion:
    """Return a motion relative to a moving frame, along the axes of that frame."""
    back = reference.pose.inverse()
    carried = reference.at(back @ motion.pose)  # the velocity of a point fixed in the frame
    linear = [a - b for a, b in zip(motion.linear, carried.linear, strict=True)]
    angular = [a - b for a, b in zip(motion.angular, carried.angular, strict=True)]
    turned = [back.rotate((x, y, z)) for x, y, z in (linear, angular)]
    return ModelMotion(back @ motion.pose, *turned)


def world_motion(reference: ModelMotion, motion: ModelMotion) -> ModelMotion:
    """Return the motion in the world for one given relative to a moving frame."""
    carried = reference.at(motion.pose)
    linear = reference.pose.rotate(motion.linear)
    angular = reference.pose.rotate(motion.angular)
    return ModelMotion(carried.pose, _sum(carried.linear, linear), _sum(carried.angular, angular))


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


MODEL_STATES = "/gazebo/model_states"
LINK_STATES = "/gazebo/link_states"


class StatesPart(Part):
    """Publishes poses and velocities of all models and links on Gazebo's topics."""

    topics = (
        TopicInfo(MODEL_STATES, ModelStates, Direction.OUT, None, "poses and velocities of all models"),
        TopicInfo(LINK_STATES, LinkStates, Direction.OUT, None, "poses and velocities of all links"),
    )

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._scene: Scene | None = None

    def read(self, topic: str, now_ns: int) -> Any:
        return self._models() if topic == MODEL_STATES else self._links()

    def _models(self) -> ModelStates:
        if self._engine.scene is not self._scene:
            self._rebuild_parts()
        poses, twists = self._poses.copy(), self._twists.copy()
        for number, name in self._moving:
            poses[number], twists[number] = state_messages(self._engine.model_motion(name))
        return ModelStates(self._names.copy(), poses, twists)

    def _rebuild_parts(self) -> None:
        """Prepare the data that change only with the scene: names, and the poses of static models."""
        self._scene = scene = self._engine.scene
        self._names = [model.name for model in scene.models]
        self._moving = [(i, model.name) for i, model in enumerate(scene.models) if not model.static]
        states = [state_messages(ModelMotion(model.pose)) for model in scene.models]
        self._poses, self._twists = [pose for pose, _ in states], [twist for _, twist in states]

    def _links(self) -> LinkStates:
        engine = self._engine
        links = [(model, link) for model, link in engine.scene.links()]
        states = [
            state_messages(
                ModelMotion(model.pose @ link.pose)
                if model.static
                else engine.link_motion(model.name, link.name)
            )
            for model, link in links
        ]
        names = [f"{model.name}::{link.name}" for model, link in links]
        return LinkStates(names, [pose for pose, _ in states], [twist for _, twist in states])
