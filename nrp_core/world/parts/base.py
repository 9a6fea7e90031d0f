"""What a part is, and what parts ask of an engine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.model import Rgba, Scene
from nrp_core.world.scene.pose import Pose, Vector
from nrp_core.world.scene.sensing import Laser
from nrp_core.world.topics import TopicInfo

ImageArray = npt.NDArray[np.uint8]
DepthArray = npt.NDArray[np.float32]
BodyPath = tuple[str, int]
"""A model and the index of one of its bodies."""


@dataclass(frozen=True, slots=True)
class ModelMotion:
    """Pose of a model's frame and its linear (m/s) and angular (rad/s) velocity, in the world's frame."""

    pose: Pose
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)

    def at(self, offset: Pose) -> ModelMotion:
        """Return how a frame moves that is rigidly held at ``offset`` in this one."""
        pose = self.pose @ offset
        (px, py, pz), (ox, oy, oz) = pose.position, self.pose.position
        x, y, z = px - ox, py - oy, pz - oz
        vx, vy, vz = self.linear
        wx, wy, wz = self.angular
        linear = (vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x)
        return ModelMotion(pose, linear, self.angular)


@dataclass(frozen=True, slots=True)
class BodyVelocity:
    """A velocity in the body's own frame: forward and left in m/s, turn (about z) in rad/s.

    ``steer`` is the angle (rad) of steered wheels that goes with it.
    """

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    steer: float = 0.0


@dataclass(frozen=True, slots=True)
class JointStates:
    """Names, positions (rad, m), velocities and efforts of joints, each of shape ``(n,)``."""

    names: tuple[str, ...]
    positions: npt.NDArray[np.float64]
    velocities: npt.NDArray[np.float64]
    efforts: npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class JointAim:
    """What a joint's servo aims at from now on.

    Its effort is ``stiffness * (position - q) + damping * (velocity - dq/dt) + effort``, taken at the end of
    each physics step (backward Euler, so that any gains are stable) and bounded by the joint's limit.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0


@dataclass(frozen=True, slots=True)
class Touch:
    """Where two bodies touched in the last physics step.

    Args:
        bodies: model and index of the body of each.
        position: in the world, m.
        normal: unit vector out of the second body.
        depth: how deep they overlap, m.
        force: what the second does to the first, N, along the world's axes.
    """

    bodies: tuple[BodyPath, BodyPath]
    position: Vector
    normal: Vector
    depth: float
    force: Vector


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force (N) and a torque (N m), along the world's axes."""

    force: Vector = (0.0, 0.0, 0.0)
    torque: Vector = (0.0, 0.0, 0.0)


class Engine(ABC):
    """What the parts ask of a physics engine."""

    scene: Scene

    @property
    @abstractmethod
    def seed(self) -> int:
        """The world's seed."""

    @property
    @abstractmethod
    def step_ns(self) -> int:
        """The physics step."""

    @abstractmethod
    def picture_size(self, model: str, link: str, camera: str) -> tuple[int, int]:
        """Return height and width of a camera's pictures."""

    @abstractmethod
    def model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves."""

    @abstractmethod
    def link_motion(self, model: str, link: str) -> ModelMotion:
        """Return where a link is and how it moves."""

    @abstractmethod
    def joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model."""

    @abstractmethod
    def render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, read-only."""

    @abstractmethod
    def depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return how far along its line of sight a camera sees, m, ``inf`` beyond its clip distance."""

    @abstractmethod
    def scan(self, model: str, link: str, laser: Laser) -> npt.NDArray[np.float64]:
        """Return the distance along each ray of a laser, m, ``inf`` where it meets nothing."""

    @abstractmethod
    def touches(self) -> Sequence[tuple[Touch, tuple[str, str]]]:
        """Return where things touched, with the names of both collisions, ``model/link/collision``."""

    @abstractmethod
    def joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return what a joint's child does to its parent, at the child link's origin."""

    @abstractmethod
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual (``model/link/visual``)."""

    @abstractmethod
    def set_glow(self, visual: str, glows: bool) -> None:
        """Let a visual have its colour in any light, or not."""

    @abstractmethod
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Let a drive aim at a velocity of the body."""

    @abstractmethod
    def set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Let a joint's servo aim at something from now on; only joints with a controller have one."""

    @abstractmethod
    def set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Put an effort (N m, N) on a joint from now on, besides what its servo does."""

    @abstractmethod
    def set_wrench(self, model: str, link: str, wrench: Wrench, of: str = "") -> bool:
        """Let a wrench act at a link's centre of mass from now on, besides those of others.

        Args:
            model: the model.
            link: its link.
            wrench: instead of the one before.
            of: who pushes.

        Returns:
            Whether its lever turns with the body, so that it is to be set again in each step.
        """


class Part(ABC):
    """A thing of the scene that serves topics.

    Attributes:
        topics: what it serves.
        deadline_ns: when it wants to be called though nobody asked, None for never.
        foresees: whether it is called one physics step before each sample, by :meth:`foresee`.
    """

    topics: tuple[TopicInfo, ...] = ()
    deadline_ns: int | None = None
    foresees: bool = False

    def read(self, topic: str, now_ns: int) -> Any:
        """Return the message of an outgoing topic as it is now."""
        raise NotImplementedError(topic)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        """Take a checked message on an incoming topic."""
        raise NotImplementedError(topic)

    def foresee(self, topic: str, now_ns: int) -> None:
        """Note what the sample in one physics step needs to know of now."""

    def at_deadline(self, now_ns: int) -> None:
        """Do what was due at :attr:`deadline_ns` and set the next one."""

    def begin(self) -> None:
        """Act on the engine before the first step, where the scene alone does not say what to do."""

    def reset(self) -> None:
        """Return to the state at time 0; the engine has been reset before."""

    def save(self) -> object:
        """Return what changes while running."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave; the engine has been restored before."""
