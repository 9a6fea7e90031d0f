"""The rover of three tasks."""

from __future__ import annotations

from math import isfinite

from nrp_core import Pose, World
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Quaternion, Twist, Vector3
from nrp_core.messages.geometry_msgs import Pose as PoseMessage
from nrp_lab.learning.task import Task

RANGE, RADIUS, HEIGHT = 2.0, 0.15, 0.05  # m


class RoverTask(Task):
    """A task for the rover of ``rover.sdf``."""

    robot = "rover.sdf"

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self.scan = world.subscribe("/rover/scan")

    def put(self, x: float, y: float, heading: float) -> None:
        """Place the rover at rest."""
        pose = Pose.from_rpy((x, y, HEIGHT), 0.0, 0.0, heading)
        state = ModelState(
            "rover", PoseMessage(Point(*pose.position), Quaternion(*pose.orientation)), Twist()
        )
        self.world.call("/gazebo/set_model_state", state)
        self.drive(0.0, 0.0)

    def pose(self) -> tuple[float, float, float]:
        """Return x and y, m, and the heading, rad."""
        pose = self.world.model_motion("rover").pose
        return pose.position[0], pose.position[1], pose.yaw

    def beams(self) -> list[float]:
        """Return the lengths of the beams from the right to the left, m."""
        latest = self.scan.latest
        if latest is None:
            return [RANGE] * 7
        return [min(float(length), RANGE) if isfinite(length) else RANGE for length in latest.message.ranges]

    def drive(self, forward: float, turn: float, left: float = 0.0) -> None:
        """Command velocities, m/s and rad/s."""
        self.publish("/rover/cmd_vel", Twist(Vector3(forward, left), Vector3(z=turn)))
