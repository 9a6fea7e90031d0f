"""What must hold in every model, however it was made: names are unique, and joints form trees."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from nrp_core.errors import SceneError, did_you_mean

if TYPE_CHECKING:
    from nrp_core.world.scene.model import Joint, Model

WORLD = "world"
"""The parent that a joint names to hold a link to the world."""
MODEL = "__model__"
"""The frame of a model, by SDF's name."""
SECOND_AXIS = "_axis2"
"""What the name of a joint ends in that is the second axis of another one."""


def check_model(model: Model) -> None:
    """Refuse a model that contradicts itself.

    Raises:
        SceneError: it has no link, two parts share a name, a joint or drive names what is not there, a link
            is held by two joints, or joints form a loop.
    """
    owner = f"the model '{model.name}'"
    links, joints = [link.name for link in model.links], [joint.name for joint in model.joints]
    if not links:
        raise SceneError(f"{owner} has no link")
    check_unique(links, "links", owner)
    check_unique(joints, "joints", owner)
    check_unique((name for joint in model.joints for name in joint.coordinates), "coordinates", owner)
    for link in model.links:
        for kind in ("visuals", "collisions", "sensors"):
            names = [part.name for part in getattr(link, kind)]
            check_unique(names, kind, f"the link '{link.name}' of {owner}")
    for joint in model.joints:
        for end, valid in ((joint.parent, [*links, WORLD]), (joint.child, links)):
            _require(end, valid, f"the joint '{joint.name}' of {owner} names the link")
        if joint.mimic is not None:
            _require_led(joint.mimic.leader, model, f"the joint '{joint.name}' of {owner} names the joint")
    _check_acting(model, owner)
    _check_tree(model.joints, owner)


def _check_acting(model: Model, owner: str) -> None:
    for drive in model.drives:
        for joint_name in drive.joints:
            _require_led(joint_name, model, f"the drive '{drive.name}' of {owner} names the joint")
    for controller in model.controllers:
        _require_led(controller.joint, model, f"a controller of {owner} names the joint")
    for follower in model.trajectory_controllers:
        for joint_name in follower.joints:
            _require_led(joint_name, model, f"the controller '{follower.name}' of {owner} names the joint")


def check_unique(names: Iterable[str], kind: str, owner: str) -> None:
    """Refuse a name that comes twice."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise SceneError(f"{owner} has two {kind} named '{name}'")
        seen.add(name)


def _require(name: str, valid: Iterable[str], what: str) -> None:
    if name not in valid:
        raise SceneError(f"{what} '{name}', which is not there{did_you_mean(name, valid)}")


def _require_led(name: str, model: Model, what: str) -> None:
    """Refuse a joint that is not there, or that a number cannot lead."""
    kinds = {joint.name: joint.kind for joint in model.joints}
    _require(name, kinds, what)
    if kinds[name] == "ball":
        raise SceneError(f"{what} '{name}', a ball joint, which does not move in one way")


def _check_tree(joints: Iterable[Joint], owner: str) -> None:
    held: dict[str, Joint] = {}
    for joint in joints:
        if joint.child in held:
            both = f"'{held[joint.child].name}' and '{joint.name}'"
            raise SceneError(
                f"in {owner} two joints, {both}, hold the link '{joint.child}'; joints form a tree"
            )
        held[joint.child] = joint
    for first in held.values():
        above, climbed = held.get(first.parent), [first.name]
        while above is not None and above is not first and len(climbed) <= len(held):
            climbed.append(above.name)
            above = held.get(above.parent)
        if above is first:
            raise SceneError(f"in {owner} the joints {', '.join(climbed)} form a loop; joints form a tree")
