"""Track a ball."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from nrp_core.messages.std_msgs import Float64
from nrp_lab.learning.task import Task

SPEED, FASTEST, VIEW, MIDDLE = 1.5, 0.6, 0.8, 0.15  # rad/s of the head and of the ball, rad


class Ball(Task):
    """The ball moves to and fro; the eye measures its bearing, and the head turns to either side or stays."""

    name = "ball"
    asks = "keep a ball in the middle of the view"
    body = "ball.sdf"
    observed = MappingProxyType({"bearing": (-VIEW, VIEW)})  # rad
    actions = ("left", "stay", "right")
    longest = 100
    training = 2000

    def begin(self, random: np.random.Generator) -> None:
        self.random, self.in_middle, self.left = random, 0, 0
        bearing = float(random.uniform(-0.6, 0.6))
        self.place("head", pan=0.0)
        self.place("ball", orbit=bearing)

    def bearing(self) -> float:
        return float(
            self.world.joint_states("ball").positions[0] - self.world.joint_states("head").positions[0]
        )

    def observe(self) -> tuple[float, ...]:
        return (self.bearing(),)

    def act(self, action: int) -> None:
        if self.left == 0:  # the ball continues at another speed
            self.left = int(self.random.integers(10, 40))
            self.publish("/ball/orbit/cmd_vel", Float64(float(self.random.uniform(-FASTEST, FASTEST))))
        self.left -= 1
        self.publish("/head/pan/cmd_vel", Float64(SPEED * (1 - action)))

    def judge(self) -> tuple[float, bool]:
        off = abs(self.bearing())
        self.in_middle += off < MIDDLE
        return -0.2 * min(off / VIEW, 1.0), False

    def score(self) -> float:
        return self.in_middle / self.longest

    def control(self) -> int:
        bearing = self.bearing()
        return 1 if abs(bearing) < 0.05 else 0 if bearing > 0 else 2
