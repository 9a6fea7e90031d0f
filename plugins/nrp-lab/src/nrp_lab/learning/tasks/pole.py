"""Balance a pole on a cart."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from nrp_core.messages.std_msgs import Float64
from nrp_lab.learning.task import Task

FORCE, FALLEN = 4.0, 0.3  # N, rad


class Pole(Task):
    """The cart is pushed with one force or the other; the episode ends when the pole has fallen."""

    name = "pole"
    asks = "balance a pole on a cart"
    body = "pole.sdf"
    observed = MappingProxyType({"angle": (-FALLEN, FALLEN), "rate": (-1.0, 1.0)})  # rad, rad/s
    actions = ("left", "right")
    longest = 250
    training = 2500

    def begin(self, random: np.random.Generator) -> None:
        lean = float(random.uniform(-0.1, 0.1))
        self.place("cart", slide=0.0, hinge=lean)

    def state(self) -> tuple[float, float, float, float]:
        joints = self.world.joint_states("cart")
        return *joints.positions, *joints.velocities

    def observe(self) -> tuple[float, ...]:
        _, angle, _, rate = self.state()
        return angle, rate

    def act(self, action: int) -> None:
        self.publish("/cart/slide/cmd_effort", Float64(FORCE * (2 * action - 1)))

    def judge(self) -> tuple[float, bool]:
        _, angle, *_ = self.state()
        fallen = abs(angle) > FALLEN
        return (-1.0 if fallen else 0.0), fallen

    def score(self) -> float:
        return self.steps / self.longest

    def control(self) -> int:
        place, angle, speed, rate = self.state()
        return int(angle + 0.5 * rate + 0.05 * place + 0.1 * speed > 0.0)
