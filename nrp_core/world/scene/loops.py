"""Joints that close loops: the tree of joints does not contain them, engines hold them together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

from nrp_core.world.rigid.pose import Pose, Vector

LOOP_KINDS: Final = ("ball", "revolute", "continuous", "fixed")
"""The kinds of joints that can close a loop."""
_ARM_M: Final = 0.05


@dataclass(frozen=True, slots=True)
class Loop:
    """A joint that closes a loop; it has no position, no limits and no friction, and takes no commands.

    Args:
        name, kind, parent, child, pose, axis: as of a :class:`~nrp_core.world.scene.model.Joint`; the loop is
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
        if self.kind == "ball":
            return (self.pose.position,)
        if self.kind == "fixed":
            arms: tuple[Vector, ...] = ((0.0, 0.0, 0.0), (_ARM_M, 0.0, 0.0), (0.0, _ARM_M, 0.0))
        else:
            x, y, z = (_ARM_M * part for part in self.axis)
            arms = ((x, y, z), (-x, -y, -z))
        return tuple((self.pose @ Pose(arm)).position for arm in arms)
