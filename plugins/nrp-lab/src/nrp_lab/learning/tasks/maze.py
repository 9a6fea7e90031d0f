"""Choose an arm of a T-maze."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from nrp_lab.learning.tasks.rover import RoverTask

SPEED, JUNCTION, END = 1.0, 1.0, 0.5  # m/s, m, m


class Maze(RoverTask):
    """The rover drives to the junction and on to the chosen side, where it receives the reward."""

    name = "maze"
    asks = "choose the arm of a T-maze that a cue means, for a delayed reward"
    body = "maze.sdf"
    observed = MappingProxyType({"cue": (-1.0, 1.0), "side": (-END, END)})
    actions = ("left", "right")
    longest = 75
    training = 3000
    tests = 12

    def begin(self, random: np.random.Generator) -> None:
        self.cue = float(random.choice((-1.0, 1.0)))
        self.put(0.0, 0.0, 0.0)

    def observe(self) -> tuple[float, ...]:
        return self.cue, self.pose()[1]

    def act(self, action: int) -> None:
        if self.pose()[0] < JUNCTION - 0.05:
            self.drive(SPEED, 0.0)
        else:
            self.drive(0.0, 0.0, SPEED * (1 - 2 * action))

    def judge(self) -> tuple[float, bool]:
        arrived = abs(self.pose()[1]) >= END
        return (float(self.is_right()) if arrived else 0.0), arrived

    def is_right(self) -> bool:
        side = self.pose()[1]
        return abs(side) >= END and (side > 0) == (self.cue > 0)

    def score(self) -> float:
        return min(max(0.5 + 0.5 * self.cue * self.pose()[1] / END, 0.0), 1.0)

    def control(self) -> int:
        return 0 if self.cue > 0 else 1
