"""The names of nodes: a participant in ROS 2 publishes the names of its nodes on one topic.

The topic, its type and its quality of service are those of ROS 2's package ``rmw_dds_common`` as of Jazzy.
"""

from __future__ import annotations

from typing import Any

from nrp_core.clock import NS_PER_S
from nrp_core.world.messages.cdr import Codec

from nrp_world_ros.node import ros_type
from nrp_world_ros.ros2.topics import DomainTopics

_TOPIC = "ros_discovery_info"
_TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"


def announce(name: str, participant: Any, codec: Codec, topics: DomainTopics) -> Any:
    """Make this process visible in ``ros2 node list``.

    Args:
        name: name of the node.
        participant: the participant of DDS.
        codec: the codec of ROS 2.
        topics: the topics of the domain.

    Returns:
        Objects that must be kept while it is visible.
    """
    from cyclonedds.core import Policy, Qos
    from cyclonedds.pub import DataWriter

    subject = topics.topic(participant, _TOPIC, _TYPE, codec)
    promises = Qos(
        Policy.Reliability.Reliable(NS_PER_S),
        Policy.Durability.TransientLocal,
        Policy.History.KeepLast(1),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Userdata(f"typehash={codec.hash(_TYPE)};".encode()),
    )
    writer = DataWriter(participant, subject, qos=promises)
    gid = ros_type("rmw_dds_common/msg/Gid")(list(participant.guid.bytes))
    node = ros_type("rmw_dds_common/msg/NodeEntitiesInfo")("/", name)
    writer.write(writer.data_type(codec.encode(ros_type(_TYPE)(gid, [node]))))
    return writer
