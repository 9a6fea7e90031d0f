"""Poses of the links of a world for ROS's tools: transforms on ``/tf``."""

from __future__ import annotations

from typing import Any

from nrp_core.errors import CapabilityError
from nrp_core.world import World
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.world.messages.std_msgs import Header

from nrp_world_ros.node import Node, ros_type

TF = "/tf"
WORLD = "world"


class Frames:
    """Publishes the frames ``model/link`` of sensor messages while there are subscribers.

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
            header = Header(Time.from_ns(now_ns), WORLD)
            links = [(model.name, link.name) for model, link in self._world.scene.links() if not model.static]
            self._publisher.publish(self._list([self._frame(header, *link) for link in links]))

    def _frame(self, header: Header, model: str, link: str) -> Any:
        try:
            pose = self._world.link_motion(model, link).pose
        except CapabilityError:  # it does not report links moved by joints: use their initial poses
            held = self._world.scene.model(model).link(link).pose
            pose = self._world.model_motion(model).pose @ held
        transform = self._transform(Vector3(*pose.position), Quaternion(*pose.orientation))
        return self._stamped(header, f"{model}/{link}", transform)
