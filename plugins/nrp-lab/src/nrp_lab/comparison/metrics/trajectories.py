"""The trajectories of robots: as curves, their ends and lengths, and the response to commands."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from math import atan2, cos, pi, sin

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.recording.export.numbers import Series
from nrp_core.recording.layout import Role
from nrp_core.world.rigid import Pose
from nrp_lab.comparison.distances import dtw_distance
from nrp_lab.comparison.metrics.base import DistanceMetric, Margin, ScalarMetric
from nrp_lab.comparison.signals import RunSignals

_POINTS = 200
"""The largest number of points of a compared trajectory; the cost of DTW is its square."""
_MM = 1e-3
_MOVING = 1e-3
"""Mean commands below this, m/s or rad/s, are too small to measure a response."""


def poses(run: RunSignals, robot: str) -> FloatArray:
    """Return the pose of a robot after each step since its first, m and quaternion, shape ``(n, 7)``."""
    values = run.held(run.motion(robot))[:, :7]
    return values[np.isfinite(values[:, 0])]


class Trajectory(DistanceMetric):
    """Mean distance of two trajectories, m, aligned in time (DTW)."""

    name, title, unit = "trajectory", "Trajectory (DTW)", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length

    def features(self, run: RunSignals) -> Mapping[str, FloatArray]:
        def thinned(robot: str) -> FloatArray:
            path = poses(run, robot)[:, :3]
            chosen = np.linspace(0, len(path) - 1, min(len(path), _POINTS)).round().astype(int)
            return np.ascontiguousarray(path[chosen])

        return {robot: thinned(robot) for robot in run.robots}

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        return dtw_distance(one, other)

    def resolution(self, run: RunSignals) -> float:
        return _MM


class FinalPosition(DistanceMetric):
    """The position of the robot at the end, m."""

    name, title, unit = "final_position", "Final position", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length

    def features(self, run: RunSignals) -> Mapping[str, FloatArray]:
        return {robot: poses(run, robot)[-1, :3] for robot in run.robots}

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        return float(np.linalg.norm(one - other))

    def resolution(self, run: RunSignals) -> float:
        return _MM


class FinalHeading(DistanceMetric):
    """The heading of the robot at the end, rad; differences are taken the shorter way round."""

    name, title, unit = "final_heading", "Final heading", "rad"
    margin = Margin(at_least=2 * pi / 180)  # two degrees, as a compass has

    def features(self, run: RunSignals) -> Mapping[str, float]:
        ends = {robot: poses(run, robot)[-1, 3:] for robot in run.robots}
        return {robot: Pose(orientation=tuple(end)).yaw for robot, end in ends.items()}

    def distance(self, one: float, other: float) -> float:
        return abs(atan2(sin(one - other), cos(one - other)))

    def resolution(self, run: RunSignals) -> float:
        return 0.1 * pi / 180


class Distance(ScalarMetric):
    """The distance that the robot has covered, m."""

    name, title, unit = "distance", "Distance covered", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length

    def parts(self, experiment: Experiment) -> Collection[str]:
        return experiment.world.robots.keys()

    def values(self, run: RunSignals) -> Mapping[str, float]:
        steps = {robot: np.diff(poses(run, robot)[:, :3], axis=0) for robot in run.robots}
        return {robot: float(np.linalg.norm(step, axis=1).sum()) for robot, step in steps.items()}

    def resolution(self, run: RunSignals) -> float:
        return _MM


class DriveResponse(ScalarMetric):
    """The response of a robot to its commands: how far it drives and turns per metre and radian commanded.

    For robots commanded on ``/ROBOT/...`` by ``geometry_msgs/Twist``. A wheel that is 2 % larger than the
    drive assumes shows as 1.02.
    """

    name, title = "drive_response", "Drive response"
    margin = Margin(at_least=0.01)  # a centimetre in a metre, as of real wheels

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        found: dict[str, float | None] = {}
        for robot, command in self._commands(run):
            commanded, done = run.held(command)[:-1], self._motion(run, robot)
            steps = min(len(commanded), len(done["turn"]))
            for name, column in (("forward", "linear.x"), ("turn", "angular.z")):
                wanted = np.nan_to_num(commanded[:steps, command.columns.index(column)])
                effort = float(np.abs(wanted).mean()) if steps else 0.0
                made = done[name][:steps] * np.sign(wanted)
                found[f"{robot}/{name}"] = float(made.mean()) / effort if effort > _MOVING else None
        return found

    def resolution(self, run: RunSignals) -> float:
        return 1e-3

    @staticmethod
    def _commands(run: RunSignals) -> Iterator[tuple[str, Series]]:
        for robot in run.robots:
            for series in run.numbers.with_role(Role.PUBLISHED):
                if series.name.startswith(f"/{robot}/") and {"linear.x", "angular.z"} <= {*series.columns}:
                    yield robot, series

    @staticmethod
    def _motion(run: RunSignals, robot: str) -> Mapping[str, FloatArray]:
        """Return the mean speeds of each step: forward, m/s, and turning, rad/s."""
        values = run.held(run.motion(robot))
        yaws = np.array([Pose(orientation=tuple(q)).yaw for q in values[:, 3:7]])
        moved = np.diff(values[:, :2], axis=0) / run.step_s
        turned = np.diff(np.unwrap(yaws)) / run.step_s
        middle = np.unwrap(yaws)[:-1] + turned * run.step_s / 2
        forward = moved[:, 0] * np.cos(middle) + moved[:, 1] * np.sin(middle)
        return {"forward": forward, "turn": turned}
