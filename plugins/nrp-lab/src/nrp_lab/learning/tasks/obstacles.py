"""Avoid obstacles."""

from __future__ import annotations

from math import pi
from types import MappingProxyType

import numpy as np

from nrp_lab.learning.tasks.rover import RADIUS, RoverTask

SPEED, TURN = 0.6, 3.0  # m/s, rad/s
COMMANDS = (0.0, TURN), (SPEED, 0.0), (0.0, -TURN)


class Obstacles(RoverTask):
    """The rover drives, or turns on the spot; the episode ends when it touches something."""

    name = "obstacles"
    asks = "drive as far as possible without touching a pillar or a wall"
    body = "obstacles.sdf"
    observed = MappingProxyType({"left": (0.0, 1.2), "right": (0.0, 1.2)})  # m, the shortest of three beams
    actions = ("turn left", "drive", "turn right")
    longest = 150
    training = 3000

    def begin(self, random: np.random.Generator) -> None:
        self.driven = 0.0
        places = ((0.0, 1.2), (0.0, -1.2), (1.2, 0.0), (-1.2, 0.0), (2.3, 2.3), (-2.3, -2.3))
        x, y = places[random.integers(len(places))]
        self.put(x, y, float(random.uniform(-pi, pi)))
        self.before = x, y

    def observe(self) -> tuple[float, ...]:
        beams = self.beams()
        return min(beams[3:6]) - RADIUS, min(beams[1:4]) - RADIUS

    def act(self, action: int) -> None:
        self.drive(*COMMANDS[action])

    def judge(self) -> tuple[float, bool]:
        x, y, _ = self.pose()
        step = float(np.hypot(x - self.before[0], y - self.before[1]))
        self.before, self.driven = (x, y), self.driven + step
        touches = min(self.beams()) < RADIUS + 0.03
        return (-1.0 if touches else 4.0 * step), touches

    def score(self) -> float:
        return min(self.driven / (SPEED * 0.04 * self.longest), 1.0)

    def control(self) -> int:
        left, right = self.observe()
        return 1 if min(left, right) > 0.3 else 0 if left > right else 2
