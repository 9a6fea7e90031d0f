"""Poses of the links of a world for ROS's tools: transforms on ``/tf``, as the tree that they expect.

Below the frame ``world`` is the base of each robot; if it has odometry, ``odom`` is between them. The links
of a robot are below its base, and the frames of its sensors below their links.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nrp_core.errors import CapabilityError
from nrp_core.world import Link, Model, Pose, World
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.world.messages.std_msgs import Header

from nrp_world_ros.node import Node, ros_type

TF = "/tf"
WORLD = "world"


class Frames:
    """Publishes the frames of sensor messages while there are subscribers.

    Args:
        world: the world with the movable models.
        node: in ROS.
    """

    def __init__(self, world: World, node: Node) -> None:
        self._world = world
        self._list = ros_type("tf2_msgs/msg/TFMessage")
        self._transform = ros_type("geometry_msgs/msg/Transform")
        self._stamped = ros_type("geometry_msgs/msg/TransformStamped")
        self._publisher = node.publisher(TF, self._list)

    def send(self, now_ns: int) -> None:
        """Publish the present poses of links."""
        if self._publisher.peers():
            now = Time.from_ns(now_ns)
            moving = [model for model in self._world.scene.models if not model.static]
            tree = (frame for model in moving for frame in self._tree(model))
            self._publisher.publish(self._list([self._frame(now, *frame) for frame in tree]))

    def _tree(self, model: Model) -> Iterator[tuple[str, str, Pose]]:
        """Yield the frames of a model: the parent, the name and the pose in the parent."""
        places = {link.name: self._place(model, link) for link in model.links}
        parent, origin = WORLD, Pose()
        if any(getattr(drive, "odometry_topic", None) for drive in model.drives):
            parent, origin = f"{model.name}/odom", model.pose
            yield WORLD, parent, origin
        first = model.links[0].name
        base = f"{model.name}/{first}"
        yield parent, base, origin.inverse() @ places[first]
        for link in model.links:
            name = f"{model.name}/{link.name}"
            if name != base:
                yield base, name, places[first].inverse() @ places[link.name]
            for sensor in link.sensors:
                own = sensor.frame_on(model.name, link.name)
                if sensor.offset is not None and own != name:
                    yield name, own, sensor.offset

    def _place(self, model: Model, link: Link) -> Pose:
        try:
            return self._world.link_motion(model.name, link.name).pose
        except CapabilityError:  # it does not report links moved by joints: use their initial poses
            return self._world.model_motion(model.name).pose @ link.pose

    def _frame(self, now: Time, parent: str, name: str, pose: Pose) -> Any:
        transform = self._transform(Vector3(*pose.position), Quaternion(*pose.orientation))
        return self._stamped(Header(now, parent), name, transform)
