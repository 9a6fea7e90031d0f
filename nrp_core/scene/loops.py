"""Joints that close loops or hold two models together: no tree of joints contains them, engines hold them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import ClassVar, Final

from nrp_core.scene.devices import LATER
from nrp_core.scene.rigid import Pose, Vector

LOOP_KINDS: Final = ("ball", "revolute", "continuous", "fixed")
"""The kinds of joints that can close a loop."""
_ARM_M: Final = 0.05
_ARM_OF_TIE_M: Final = 0.5
"""Whole models pull at a tie: about arms of 5 cm PyBullet's solver lets 2 kg at 45 cm sag by 3 degrees."""


@dataclass(frozen=True, slots=True)
class Loop:
    """A joint that closes a loop; it has no position, no limits and no friction, and takes no commands.

    Args:
        name, kind, parent, child, pose, axis: as of a :class:`~nrp_core.scene.model.Joint`; the loop is
            closed where all joints are at 0.
    """

    tag: ClassVar[str] = "loop"

    name: str
    kind: str
    parent: str
    child: str
    pose: Pose = Pose()
    axis: Vector = (0.0, 0.0, 1.0)

    @property
    def points(self) -> tuple[Vector, ...]:
        """The points, in the frame of the model, that its links have in common.

        A ball joint has one, a joint that turns two on its axis, and a fixed one three.
        """
        return tuple((self.pose @ Pose(arm)).position for arm in _arms(self.kind, self.axis, _ARM_M))


@dataclass(frozen=True, slots=True)
class Freedom:
    """One of the ways in which a tie lets two models move; fields as of a joint.

    The kind is ``revolute``, ``continuous`` or ``prismatic``, and the axis is given in the frame of the tie.
    """

    kind: str
    axis: Vector
    lower: float = -inf
    upper: float = inf
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True, slots=True)
class Tie:
    """A joint between two models; like one that closes a loop, it has no position and takes no commands.

    Args:
        name, axis: as of a :class:`~nrp_core.scene.model.Joint`.
        kind: the same, or the type of a joint of SDF with several axes.
        parent, child: a model and its link.
        in_parent, in_child: the joint's pose in the frames of both models, where all their joints are at 0.
        freedoms: how they move, from the parent to the child, if no points in common describe it.
    """

    tag: ClassVar[str] = "tie"

    name: str
    kind: str
    parent: tuple[str, str]
    child: tuple[str, str]
    in_parent: Pose = Pose()
    in_child: Pose = Pose()
    axis: Vector = (0.0, 0.0, 1.0)
    freedoms: tuple[Freedom, ...] = field(default=(), metadata=LATER)

    @property
    def points(self) -> tuple[tuple[Vector, Vector], ...]:
        """The points that the links have in common, each in the frames of both models, the parent's first.

        Those of a tie with freedoms are common where all of these are at 0.
        """
        arms = [Pose(arm) for arm in _arms(self.kind, self.axis, _ARM_OF_TIE_M)]
        return tuple(((self.in_parent @ arm).position, (self.in_child @ arm).position) for arm in arms)


def _arms(kind: str, axis: Vector, length: float) -> tuple[Vector, ...]:
    """Return points in the frame of a joint that its links have in common."""
    if kind == "ball":
        return ((0.0, 0.0, 0.0),)
    if kind in ("revolute", "continuous"):
        x, y, z = (length * part for part in axis)
        return ((x, y, z), (-x, -y, -z))
    return ((0.0, 0.0, 0.0), (length, 0.0, 0.0), (0.0, length, 0.0))
