"""Create a node of ROS 1 or ROS 2."""

from __future__ import annotations

from nrp_world_ros.node import Node
from nrp_world_ros.options import Ros


def join(ros: Ros, name: str, *, queue: int = 0, domain: int | None = None, parameters: bool = False) -> Node:
    """Become a node of ROS.

    Args:
        ros: the version of ROS.
        name: name of the node, unless this process has already started one.
        queue: queue length for a slow subscriber, beyond which the oldest messages are lost; 0: unlimited.
        parameters: whether it offers the services of parameters of ROS 2.
        domain: domain of ROS 2; by default ``ROS_DOMAIN_ID``, else 0.

    Raises:
        BackendLoadError: a requirement is missing.
    """
    if ros is Ros.ONE:
        from nrp_world_ros.ros1 import Ros1Node

        return Ros1Node(name, queue=queue)
    from nrp_world_ros.ros2.node import Ros2Node

    return Ros2Node(name, queue=queue, domain=domain, parameters=parameters)
