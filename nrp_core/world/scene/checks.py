"""Checks of every model, however it was made: names are unique, and joints form trees."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from nrp_core.errors import SceneError, did_you_mean

WORLD = "world"
"""The name of the parent of a joint that fixes a link to the world."""
MODEL = "__model__"
"""SDF's name of the frame of a model."""
SECOND_AXIS = "_axis2"
"""The suffix of a joint's name that is the second axis of another one."""


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
