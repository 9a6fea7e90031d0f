"""Joints of SDF worlds, which hold a model in place or let it turn, slide or swing about a fixed axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.checks import WORLD
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
    """Yield each joint between the world and a model, with the name of the model, in the frame of the world.

    A joint between two models is left out with a warning, because the joints of a scene belong to one model.

    Raises:
        SceneError: a joint is wrong, or one of its ends does not exist.
    """
    for joint in world.all("joint"):
        name, row = joint.attribute("name"), read_joint(joint, frames, version, reading)
        if row[0].parent != WORLD:
            message = f"the joint '{name}' between two models is not simulated: left out"
            reading.notes.warn(joint, Code.NRP260, message, subject=name)
        else:
            yield row[-1].child.partition("::")[0], row


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
