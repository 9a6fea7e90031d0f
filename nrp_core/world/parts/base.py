"""What a part is, and what parts ask of an engine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.model import Rgba
from nrp_core.world.scene.pose import Pose, Vector
from nrp_core.world.topics import TopicInfo


@dataclass(frozen=True, slots=True)
class ModelMotion:
    """Pose of a model's frame and its linear (m/s) and angular (rad/s) velocity, in the world's frame."""

    pose: Pose
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)

    def at(self, offset: Pose) -> ModelMotion:
        """Return how a frame moves that is rigidly held at ``offset`` in this one."""
        pose = self.pose @ offset
        x, y, z = (there - here for there, here in zip(pose.position, self.pose.position, strict=True))
        vx, vy, vz = self.linear
        wx, wy, wz = self.angular
        linear = (vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x)
        return ModelMotion(pose, linear, self.angular)


@dataclass(frozen=True, slots=True)
class BodyVelocity:
    """A velocity in the body's own frame: forward and left in m/s, turn (about z) in rad/s."""

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True, slots=True)
class JointStates:
    """Names, positions (rad, m), velocities and efforts of joints, each of shape ``(n,)``."""

    names: tuple[str, ...]
    positions: npt.NDArray[np.float64]
    velocities: npt.NDArray[np.float64]
    efforts: npt.NDArray[np.float64]


class Engine(ABC):
    """What the parts ask of a physics engine."""

    @abstractmethod
    def model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves."""

    @abstractmethod
    def joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model."""

    @abstractmethod
    def render(self, model: str, link: str, camera: str) -> npt.NDArray[np.uint8]:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, read-only."""

    @abstractmethod
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual (``model/link/visual``)."""

    @abstractmethod
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Let a drive aim at a velocity of the body."""


class Part(ABC):
    """A thing of the scene that serves topics.

    Attributes:
        topics: what it serves.
        deadline_ns: when it wants to be called though nobody asked, None for never.
    """

    topics: tuple[TopicInfo, ...] = ()
    deadline_ns: int | None = None

    def read(self, topic: str, now_ns: int) -> Any:
        """Return the message of an outgoing topic as it is now."""
        raise NotImplementedError(topic)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        """Take a checked message on an incoming topic."""
        raise NotImplementedError(topic)

    def at_deadline(self, now_ns: int) -> None:
        """Do what was due at :attr:`deadline_ns` and set the next one."""

    def reset(self) -> None:
        """Return to the state at time 0; the engine has been reset before."""

    def save(self) -> object:
        """Return what changes while running."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave; the engine has been restored before."""
