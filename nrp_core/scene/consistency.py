"""Checks of every model from any source: names are unique, and joints form trees."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import hypot, isfinite
from typing import Final

from nrp_core._support.checked_arguments import is_number
from nrp_core.errors import SceneError, did_you_mean
from nrp_core.scene.rigid import Pose

WORLD = "world"
"""The name of the parent of a joint that fixes a link to the world."""
MODEL = "__model__"
"""SDF's name of the frame of a model."""
SECOND_AXIS = "_axis2"
"""The suffix of a joint's name that is the second axis of another one."""

_ROUNDING: Final = 1e-3
"""Of the length of a quaternion."""


def check_pose(pose: object, owner: str) -> None:
    """Refuse a pose that is not a position and a unit quaternion."""
    if not isinstance(pose, Pose):
        raise SceneError(f"the pose of {owner} is {pose!r:.60}, not a Pose")
    for what, values, n in (("position", pose.position, 3), ("orientation", pose.orientation, 4)):
        numbers = tuple(values) if isinstance(values, Iterable) else (values,)
        if len(numbers) != n or not all(is_number(one) and isfinite(one) for one in numbers):
            raise SceneError(f"the {what} of {owner} must be {n} finite numbers, not {values!r:.60}")
    length = hypot(*pose.orientation)
    if abs(length - 1.0) > _ROUNDING:
        raise SceneError(
            f"the orientation of {owner} must be a quaternion x, y, z, w of length 1; it is {length:g}"
        )


def check_unique(names: Iterable[str], kind: str, owner: str) -> None:
    """Refuse duplicate names."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise SceneError(f"{owner} has two {kind} named '{name}'")
        seen.add(name)


def require(name: str, valid: Iterable[str], owner: str) -> None:
    """Refuse a name that does not exist.

    Args:
        name: the name.
        valid: the existing names.
        owner: the referring element, with a verb, for the message.
    """
    if name not in valid:
        raise SceneError(f"{owner} '{name}', which does not exist{did_you_mean(name, valid)}")


def rigid_groups(names: Iterable[str], fixed: Iterable[tuple[str, ...]]) -> Mapping[str, set[str]]:
    """Return for each name the names that are fixed to it, itself included.

    Args:
        names: the names.
        fixed: pairs of names that are fixed to each other; those of other names are ignored.
    """
    rigid = {name: {name} for name in names}
    for one, other in fixed:
        if one in rigid and other in rigid:
            joined = rigid[one] | rigid[other]
            rigid |= dict.fromkeys(joined, joined)
    return rigid


def check_tree(joints: Iterable[tuple[str, str, str]], owner: str) -> None:
    """Refuse joints that hold one link twice, or form a loop.

    Args:
        joints: name, parent and child of each.
        owner: the model, for the message.
    """
    held: dict[str, tuple[str, str]] = {}
    for name, parent, child in joints:
        if child in held:
            both = f"'{held[child][0]}' and '{name}'"
            raise SceneError(f"in {owner} two joints, {both}, hold the link '{child}'; joints form a tree")
        held[child] = name, parent
    for first in held.values():
        above, climbed = held.get(first[1]), [first[0]]
        while above is not None and above is not first and len(climbed) <= len(held):
            climbed.append(above[0])
            above = held.get(above[1])
        if above is first:
            raise SceneError(
                f"in {owner} the joints {', '.join(climbed)} form a loop; joints must form a tree"
            )
