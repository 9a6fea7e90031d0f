"""A task of the ladder: a body in a world, numbers that are observed, actions to choose from, and a score."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nrp_core import World

STEP_MS = 40


class Task(ABC):
    """Episodes in a world; a learner sees numbers, chooses actions and receives rewards.

    Attributes:
        name: its name.
        asks: what the brain must learn, in a few words.
        body: file of the world, beside the module of the task.
        observed: names and ranges of the observed quantities; a learner gets them scaled to -1 to 1.
        actions: names of the actions.
        longest: number of steps after which an episode ends.
        training, tests: number of episodes.
    """

    name: ClassVar[str]
    asks: ClassVar[str]
    body: ClassVar[str]
    observed: ClassVar[Mapping[str, tuple[float, float]]]
    actions: ClassVar[tuple[str, ...]]
    longest: ClassVar[int]
    robot: ClassVar[str] = ""
    training: ClassVar[int]
    tests: ClassVar[int] = 6
    folder: ClassVar[Path] = Path(__file__).parent / "tasks"

    def __init__(self, world: World) -> None:
        self.world = world
        self.steps = 0
        self._publications: dict[str, Any] = {}

    @abstractmethod
    def begin(self, random: np.random.Generator) -> None:
        """Place the body for a new episode."""

    @abstractmethod
    def observe(self) -> Sequence[float]:
        """Return the observed numbers in their own units."""

    @abstractmethod
    def act(self, action: int) -> None:
        """Command the body for one step."""

    @abstractmethod
    def judge(self) -> tuple[float, bool]:
        """Return the reward of the last step, and whether it has ended the episode."""

    @abstractmethod
    def score(self) -> float:
        """Return the score of the episode so far, from 0 to 1."""

    @abstractmethod
    def control(self) -> int:
        """Return the action that a known controller chooses; learners never see it."""

    def publish(self, topic: str, message: Any) -> None:
        """Publish on a topic of the body."""
        if topic not in self._publications:
            self._publications[topic] = self.world.advertise(topic)
        self._publications[topic].publish(message)

    def scaled(self) -> list[float]:
        """Return the observed numbers from -1 to 1; those out of their range are at its ends."""
        ranges = self.observed.values()
        return [
            min(max(2.0 * (value - low) / (high - low) - 1.0, -1.0), 1.0)
            for value, (low, high) in zip(self.observe(), ranges, strict=True)
        ]

    def place(self, model: str, **joints: float) -> None:
        """Set positions of joints, at rest."""
        names, positions = list(joints), list(joints.values())
        self.world.call("/gazebo/set_model_configuration", model, "", names, positions)
