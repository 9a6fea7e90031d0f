"""Poses and velocities of bodies, and states of their joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nrp_core.scene.merged_bodies import Body, tree_of
from nrp_core.scene.rigid import rotation_by
from nrp_core.world import FloatArray, JointStates, ModelMotion, Pose
from nrp_core.world.engine_kit.jointed import MotionOf
from nrp_world_gazebo.build import BodyHandle, Coordinate
from nrp_world_gazebo.process import Gazebo
from nrp_world_gazebo.wire import operation


class Moving:
    """A frame at an offset from the frame of a link.

    Args:
        gazebo: the process.
        link: the number of the link.
        offset: pose of the frame in that of the link.
    """

    def __init__(self, gazebo: Gazebo, link: int, offset: Pose) -> None:
        self.gazebo, self._link, self._offset = gazebo, link, offset
        self._plain = offset == Pose()

    def __call__(self) -> ModelMotion:
        self.gazebo.refresh()
        motion = motion_of(self.gazebo.links[self._link])
        return motion if self._plain else motion.at(self._offset)


class Hinged:
    """A frame on a body that moves on a joint, at the pose that the joint's position determines.

    ODE's joints give way by some micrometres; the reported poses of links do not.

    Args:
        moving: the frame as ODE has it, for its velocity.
        parent: the motion of the frame of the parent body.
        coordinate: the handle of the joint.
        place: pose of the body in the parent with the joint at 0.
        offset: pose of the frame in the body's frame.
    """

    def __init__(
        self, moving: Moving, parent: MotionOf, coordinate: Coordinate, place: Pose, offset: Pose
    ) -> None:
        self._moving, self._parent, self._coordinate = moving, parent, coordinate
        self._place, self._offset = place, offset

    def __call__(self) -> ModelMotion:
        motion = self._moving()
        position = float(self._moving.gazebo.joints[self._coordinate.number, 0])
        held = self._place @ travel(self._coordinate, position) @ self._offset
        return ModelMotion(self._parent().pose @ held, motion.linear, motion.angular)


class Tree:
    """A root and all bodies that hang on it, which move together when it is placed.

    Args:
        gazebo: the process.
        bodies: the bodies of the model with their handles.
        root: index of the root among them.
    """

    def __init__(self, gazebo: Gazebo, bodies: Sequence[tuple[Body, BodyHandle]], root: int) -> None:
        self._gazebo = gazebo
        parts = tree_of(root, [body for body, _ in bodies])
        self._links = [link for index in parts for link in bodies[index][1].links]
        self._base = Moving(gazebo, self._links[0], bodies[root][1].held)

    def __call__(self) -> ModelMotion:
        return self._base()

    def put(self, motion: ModelMotion) -> None:
        """Set pose and velocity of the root; the others keep their poses and velocities relative to it."""
        before = self._base()
        moved = motion.pose @ before.pose.inverse()
        for link in self._links:
            now = motion_of(self._gazebo.links[link])
            carried = before.at(before.pose.inverse() @ now.pose)
            pose = moved @ now.pose
            there = motion.at(motion.pose.inverse() @ pose)
            linear = _sum(there.linear, moved.rotate(_less(now.linear, carried.linear)))
            angular = _sum(there.angular, moved.rotate(_less(now.angular, carried.angular)))
            put(self._gazebo, link, ModelMotion(pose, linear, angular))


class JointReader:
    """Reads the movable joints of one model.

    Args:
        gazebo: the process.
        joints: handles of the coordinates by name, in the order of the file.
    """

    def __init__(self, gazebo: Gazebo, joints: Mapping[str, Coordinate]) -> None:
        self._gazebo, self._names = gazebo, tuple(joints)
        self._numbers = np.array([place.number for place in joints.values()], dtype=int)

    def states(self) -> JointStates:
        """Return positions, velocities and efforts; the efforts are those of the last physics step."""
        self._gazebo.refresh()
        positions, velocities, efforts = self._gazebo.joints[self._numbers].T.copy()
        return JointStates(self._names, positions, velocities, efforts)


def travel(place: Coordinate, position: float) -> Pose:
    """Return the motion of a joint from 0 to a position, in its frame."""
    x, y, z = (part * position for part in place.joint.axis)
    if place.joint.kind == "prismatic":
        return Pose((x, y, z))
    return Pose(orientation=rotation_by((x, y, z)))


def motion_of(row: FloatArray) -> ModelMotion:
    """Return the motion in the row of a link."""
    x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = row.tolist()
    return ModelMotion(Pose((x, y, z), (qx, qy, qz, qw)), (vx, vy, vz), (wx, wy, wz))


def put(gazebo: Gazebo, link: int, motion: ModelMotion) -> None:
    """Set pose and velocity of a link's frame."""
    row = (*motion.pose.position, *motion.pose.orientation, *motion.linear, *motion.angular)
    gazebo.do(operation("p", link, values=row))
    gazebo.links[link] = row


def _sum(a: tuple[float, float, float], b: tuple[float, float, float]) -> tuple[float, float, float]:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _less(a: tuple[float, float, float], b: tuple[float, float, float]) -> tuple[float, float, float]:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
