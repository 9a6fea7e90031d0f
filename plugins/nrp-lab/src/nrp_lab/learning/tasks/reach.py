"""Reach for a target with an arm of two links."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from types import MappingProxyType

import numpy as np

from nrp_core.messages.std_msgs import Float64
from nrp_lab.learning.task import Task

LENGTH, SPEED, NEAR = 0.3, 1.0, 0.04  # m, rad/s, m
COMMANDS = (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)  # of shoulder and elbow


class Reach(Task):
    """The target has a new position in each episode, which ends when the hand reaches it."""

    name = "reach"
    asks = "reach for a target with two joints"
    body = "reach.sdf"
    observed = MappingProxyType(
        {"direction": (-1.0, 1.0), "distance": (-0.25, 0.25)}
    )  # rad, m, of the target less the hand
    actions = ("shoulder left", "shoulder right", "bend", "stretch")
    longest = 75
    training = 2000

    def begin(self, random: np.random.Generator) -> None:
        self.place("arm", shoulder=float(random.uniform(-0.5, 0.5)), elbow=float(random.uniform(1.0, 1.8)))
        while True:
            self.target = float(random.uniform(-1.0, 1.0)), float(random.uniform(0.25, 0.5))
            self.far = self.before = self.miss()
            if self.far > 0.2:
                return

    def hand(self) -> tuple[float, float]:
        shoulder, elbow = self.world.joint_states("arm").positions
        x = LENGTH * (cos(shoulder) + cos(shoulder + elbow))
        y = LENGTH * (sin(shoulder) + sin(shoulder + elbow))
        return atan2(y, x), hypot(x, y)

    def miss(self) -> float:
        (one, near), (other, far) = self.hand(), self.target
        return hypot(near * cos(one) - far * cos(other), near * sin(one) - far * sin(other))

    def observe(self) -> tuple[float, ...]:
        direction, distance = self.hand()
        turn = (self.target[0] - direction + pi) % (2 * pi) - pi
        return turn, self.target[1] - distance

    def act(self, action: int) -> None:
        for joint, command in zip(("shoulder", "elbow"), COMMANDS[action], strict=True):
            self.publish(f"/arm/{joint}/cmd_vel", Float64(SPEED * command))

    def judge(self) -> tuple[float, bool]:
        before, self.before = self.before, self.miss()
        there = self.before < NEAR
        return 10.0 * (before - self.before) + there, there

    def score(self) -> float:
        return 1.0 if self.miss() < NEAR else max(0.0, 1.0 - self.miss() / self.far)

    def control(self) -> int:
        turn, stretch = self.observe()
        if abs(turn) * self.target[1] > abs(stretch):
            return 0 if turn > 0 else 1
        return 3 if stretch > 0 else 2
