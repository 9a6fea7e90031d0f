"""Joints of SDF worlds, which hold a model to the world, or two models together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.loops import LOOP_KINDS, Freedom, Tie
from nrp_core.world.scene.model import Joint
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.compound import Row
from nrp_core.world.scene.sdf.frames import Frames
from nrp_core.world.scene.sdf.joints import read_joint


def add_joint_frames(world: Element, frames: Frames) -> None:
    """Add the frames of the joints of a world, which are attached to the child."""
    for joint in world.all("joint"):
        child = joint.require("child").text
        frames.add(joint, child, attached_to=child)


def read_world_joints(
    world: Element, frames: Frames, version: tuple[int, int], reading: Reading
) -> Iterator[tuple[str, Row]]:
    """Yield each joint of a world in the frame of the world, with the name of the model of its child.

    Raises:
        SceneError: a joint is wrong, or one of its ends does not exist.
    """
    for joint in world.all("joint"):
        row = read_joint(joint, frames, version, reading)
        owner, other = (end.partition("::")[0] for end in (row[-1].child, row[0].parent))
        if other not in (owner, WORLD) and any(each.mimic for each in row):
            name, kind = joint.attribute("name"), joint.attribute("type")
            message = f"the joint '{name}' between two models is {kind}, which is not simulated: left out"
            reading.notes.warn(joint, Code.NRP260, message, subject=name)
        else:
            yield owner, row


def tie_of(row: Row, poses: Mapping[str, Pose], kinds: Mapping[str, str]) -> Tie | None:
    """Return a joint of the world as one between two models; None if it is in one.

    Args:
        row: the joint, in the frame of the world.
        poses: the poses of all models in the world.
        kinds: the types of the joints in the file.
    """
    (parent, _, holder), (child, _, held) = (end.partition("::") for end in (row[0].parent, row[-1].child))
    if parent in (child, WORLD):
        return None
    joint = row[0]
    freedoms: tuple[Freedom, ...] = ()
    if len(row) > 1 or joint.kind not in LOOP_KINDS:
        freedoms = tuple(_freedom(each, joint.pose) for each in row)
    name = next(each.name for each in row if each.name in kinds)
    kind = joint.kind if len(row) == 1 else kinds[name]
    in_parent, in_child = (poses[name].inverse() @ joint.pose for name in (parent, child))
    ends = (parent, holder), (child, held)
    return Tie(name, kind, *ends, in_parent, in_child, joint.axis, freedoms)


def _freedom(joint: Joint, tie: Pose) -> Freedom:
    axis = tie.rotate_back(joint.pose.rotate(joint.axis))
    limits = joint.lower, joint.upper
    return Freedom(joint.kind, axis, *limits, joint.damping, joint.friction, joint.stiffness, joint.rest)


def in_model(row: Row, model: str, pose: Pose) -> Row:
    """Return a joint of the world as one of a model.

    Args:
        row: the joint, in the frame of the world.
        model: the name of the model.
        pose: the pose of the model in the world.
    """
    prefix = f"{model}::"
    return tuple(
        replace(
            joint,
            parent=joint.parent.removeprefix(prefix),
            child=joint.child.removeprefix(prefix),
            pose=pose.inverse() @ joint.pose,
        )
        for joint in row
    )
