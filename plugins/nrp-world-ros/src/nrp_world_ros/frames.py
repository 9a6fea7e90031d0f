"""Poses of the links of a world for ROS's tools: transforms on ``/tf`` and ``/tf_static``, as one tree.

Below the frame ``world`` is the base of each robot; if it has odometry, ``odom`` is between them. The links
of a robot are below its base, and the frames of its sensors below their links. What never moves in its parent
is on ``/tf_static``: the frames of sensors, and the links with sensors of models that never move. Below a
bare ``odom`` is ``world``, because a frame has one parent and Nav2 publishes ``map`` as that of ``odom``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeAlias

from nrp_core.errors import CapabilityError
from nrp_core.messages.base import Time
from nrp_core.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.messages.std_msgs import Header
from nrp_core.world import Link, Model, Pose, Scene, World

from nrp_world_ros.node import Node, ros_type

TF, TF_STATIC = "/tf", "/tf_static"
WORLD = "world"

Frame: TypeAlias = tuple[str, str, Pose]
"""The parent of a frame, its name, and its pose in the parent."""


class Frames:
    """Publishes the frames of sensor messages: those that move while there are subscribers.

    Args:
        world: the world with the movable models.
        node: in ROS.
        bare: removes the prefix from the name of a frame.
    """

    def __init__(self, world: World, node: Node, bare: Callable[[str], str] = str) -> None:
        self._world, self._bare = world, bare
        self._list = ros_type("tf2_msgs/msg/TFMessage")
        self._transform = ros_type("geometry_msgs/msg/Transform")
        self._stamped = ros_type("geometry_msgs/msg/TransformStamped")
        self._moving = node.publisher(TF, self._list)
        self._static = node.publisher(TF_STATIC, self._list, latched=True)
        self._told: Scene | None = None

    def send(self, now_ns: int) -> None:
        """Publish the present poses of links; those that never move once for each scene."""
        scene = self._world.scene
        if self._told is not scene:
            self._told = scene
            static = [frame for model in scene.models for frame in _static_tree(model)]
            self._static.publish(self._message(now_ns, static))
        if self._moving.peers():
            moving = [model for model in scene.models if not model.static]
            tree = [frame for model in moving for frame in self._tree(model)]
            self._moving.publish(self._message(now_ns, tree))

    def _tree(self, model: Model) -> Iterator[Frame]:
        """Yield the frames of the links of a model, and of its odometry."""
        places = {link.name: self._place(model, link) for link in model.links}
        parent, origin = WORLD, Pose()
        if any(getattr(drive, "odometry_topic", None) for drive in model.drives):
            parent, origin = f"{model.name}/odom", model.pose
            is_root = self._bare(parent) != parent
            yield (parent, WORLD, origin.inverse()) if is_root else (WORLD, parent, origin)
        first = model.links[0].name
        base = f"{model.name}/{first}"
        yield parent, base, origin.inverse() @ places[first]
        for link in model.links:
            name = f"{model.name}/{link.name}"
            if name != base:
                yield base, name, places[first].inverse() @ places[link.name]

    def _place(self, model: Model, link: Link) -> Pose:
        try:
            return self._world.link_motion(model.name, link.name).pose
        except CapabilityError:  # it does not report links moved by joints: use their initial poses
            return self._world.model_motion(model.name).pose @ link.pose

    def _message(self, now_ns: int, frames: Iterable[Frame]) -> Any:
        now = Time.from_ns(now_ns)
        return self._list([self._transformed(now, *frame) for frame in frames])

    def _transformed(self, now: Time, parent: str, name: str, pose: Pose) -> Any:
        transform = self._transform(Vector3(*pose.position), Quaternion(*pose.orientation))
        return self._stamped(Header(now, self._bare(parent)), self._bare(name), transform)


def _static_tree(model: Model) -> Iterator[Frame]:
    """Yield the frames of the sensors of a model; if it never moves also those of their links."""
    told = {f"{model.name}/{link.name}" for link in model.links}
    seen = any(link.sensors for link in model.links)
    for link in model.links:
        name = f"{model.name}/{link.name}"
        if model.static and seen:
            yield WORLD, name, model.pose @ link.pose
        for sensor in link.sensors:
            own = sensor.frame_on(model.name, link.name)
            if sensor.offset is not None and own not in told:
                told.add(own)
                yield name, own, sensor.offset
