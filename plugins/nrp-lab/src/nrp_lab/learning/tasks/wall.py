"""Follow a wall."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from types import MappingProxyType

import numpy as np

from nrp_lab.learning.tasks.rover import RADIUS, RoverTask

SPEED, TURN = 1.0, 2.0  # m/s, rad/s
WALL, WANTED, BAND, LOST = 2.0, 0.5, 0.15, 1.2  # m, its radius and distances from it


class Wall(RoverTask):
    """The wall is at the right; the episode ends when the rover touches or loses it."""

    name = "wall"
    asks = "follow a wall at a distance of half a metre"
    body = "wall.sdf"
    observed = MappingProxyType({"right": (0.0, LOST), "ahead right": (0.0, 2.0)})  # m
    actions = ("left", "straight", "right")
    longest = 150
    training = 4000

    def begin(self, random: np.random.Generator) -> None:
        self.in_band = 0
        around = float(random.uniform(-pi, pi))
        away = WALL + RADIUS + float(random.uniform(0.25, 0.75))
        heading = around - pi / 2 + float(random.uniform(-0.3, 0.3))
        self.put(away * cos(around), away * sin(around), heading)

    def distance(self) -> float:
        x, y, _ = self.pose()
        return hypot(x, y) - WALL - RADIUS

    def observe(self) -> tuple[float, ...]:
        beams = self.beams()
        return beams[0] - RADIUS, beams[1] - RADIUS

    def act(self, action: int) -> None:
        self.drive(SPEED, TURN * (1 - action))

    def judge(self) -> tuple[float, bool]:
        distance = self.distance()
        self.in_band += abs(distance - WANTED) < BAND
        over = distance < 0.02 or distance > LOST
        return (-1.5 if over else 0.45 * max(0.0, 1.0 - 2.0 * abs(distance - WANTED))), over

    def score(self) -> float:
        return self.in_band / self.longest

    def control(self) -> int:
        x, y, heading = self.pose()
        along = atan2(y, x) - pi / 2
        wanted = along - 1.5 * (self.distance() - WANTED)  # right of the wall's direction is towards it
        turn = (wanted - heading + pi) % (2 * pi) - pi
        return 1 if abs(turn) < 0.1 else 0 if turn > 0 else 2
