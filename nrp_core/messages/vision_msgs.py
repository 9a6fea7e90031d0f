"""ROS package vision_msgs: objects that a camera recognised."""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import message
from nrp_core.messages.geometry_msgs import Pose, PoseWithCovariance, Vector3
from nrp_core.messages.std_msgs import Header


@message("vision_msgs/msg/ObjectHypothesis")
class ObjectHypothesis:
    """The kind of an object, and the confidence that it is one, from 0 to 1."""

    class_id: str = ""
    score: float = 0.0


@message("vision_msgs/msg/ObjectHypothesisWithPose")
class ObjectHypothesisWithPose:
    """A kind of object and the pose of such an object."""

    hypothesis: ObjectHypothesis = field(default_factory=ObjectHypothesis)
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)


@message("vision_msgs/msg/BoundingBox3D")
class BoundingBox3D:
    """A box by its centre and its size (m); a size of 0 is unknown."""

    center: Pose = field(default_factory=Pose)
    size: Vector3 = field(default_factory=Vector3)


@message("vision_msgs/msg/Detection3D")
class Detection3D:
    """An object: its possible classes, its pose, and its name if it is tracked."""

    header: Header = field(default_factory=Header)
    results: list[ObjectHypothesisWithPose] = field(default_factory=list)
    bbox: BoundingBox3D = field(default_factory=BoundingBox3D)
    id: str = ""


@message("vision_msgs/msg/Detection3DArray")
class Detection3DArray:
    """The objects that are seen at one time."""

    header: Header = field(default_factory=Header)
    detections: list[Detection3D] = field(default_factory=list)
