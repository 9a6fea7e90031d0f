"""Poses and motions as messages, and back."""

from __future__ import annotations

from typing import Any

from nrp_core.world.messages.geometry_msgs import Point, Quaternion, Twist, Vector3
from nrp_core.world.messages.geometry_msgs import Pose as PoseMessage
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Pose, Vector, multiply


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


def seen_from(reference: ModelMotion, motion: ModelMotion) -> ModelMotion:
    """Return a motion relative to a moving frame, along the axes of that frame."""
    back = reference.pose.inverse()
    carried = reference.at(back @ motion.pose)  # the velocity of a point fixed in the frame
    linear = [a - b for a, b in zip(motion.linear, carried.linear, strict=True)]
    angular = [a - b for a, b in zip(motion.angular, carried.angular, strict=True)]
    turned = [back.rotate((x, y, z)) for x, y, z in (linear, angular)]
    return ModelMotion(back @ motion.pose, *turned)


def seen_in_world(reference: ModelMotion, motion: ModelMotion) -> ModelMotion:
    """Return the motion in the world for one given relative to a moving frame."""
    carried = reference.at(motion.pose)
    linear = reference.pose.rotate(motion.linear)
    angular = reference.pose.rotate(motion.angular)
    return ModelMotion(carried.pose, _sum(carried.linear, linear), _sum(carried.angular, angular))


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
