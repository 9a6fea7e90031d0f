"""Gearboxes and plugins that make one joint follow another."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Joint, Mimic
from nrp_core.world.scene.reading.context import Element, Reading
from nrp_core.world.scene.reading.plugins import name_of_file
from nrp_core.world.scene.sdf.compound import Row, direction
from nrp_core.world.scene.sdf.frames import Frames

_NAME: Final = re.compile(r"(?:roboticsgroup_(?:upatras_)?)?gazebo_mimic_joint_plugin")


def couples(plugin: Element) -> bool:
    """Return whether a plugin couples two joints."""
    return _NAME.fullmatch(name_of_file(plugin)) is not None


def with_coupled(rows: Iterable[Row], plugins: Iterable[Element], reading: Reading) -> list[Row]:
    """Return the joints of a model; those that plugins couple follow others, unless they do so already.

    Args:
        rows: the joints, including those of nested models.
        plugins: the plugins of the model.
        reading: the context of the reading.

    Raises:
        SceneError: a plugin couples a joint with itself.
    """
    rows = list(rows)
    for plugin in filter(couples, plugins):
        ends = [plugin.require(tag) for tag in ("joint", "mimicJoint")]
        names = [joint.name for row in rows for joint in row]
        if ends[0].text == ends[1].text:
            raise plugin.error(f"the joint '{ends[0].text}' mimics itself")
        absent = [end for end in ends if end.text not in names]
        for end in absent[:1]:
            hint = did_you_mean(end.text, names)
            message = f"the model has no joint '{end.text}'{hint}: the plugin couples nothing"
            reading.notes.warn(end, Code.NRP265, message, subject=end.text)
        if not absent:
            leader, follower = (end.text for end in ends)
            follows = Mimic(leader, plugin.number("multiplier", 1.0), plugin.number("offset", 0.0))
            rows = [_following(row, follower, follows) for row in rows]
    return rows


def _following(row: Row, follower: str, follows: Mimic) -> Row:
    return tuple(
        replace(joint, mimic=follows) if joint.name == follower and joint.mimic is None else joint
        for joint in row
    )


_ROUNDING = 1e-6


def with_gears(
    rows: Iterable[Row], model: Element, frames: Frames, version: tuple[int, int], reading: Reading
) -> list[Row]:
    """Return the joints of a model, with those coupled by gearboxes following others.

    Args:
        rows: the joints, including those of nested models.
        model: the element that holds the gearboxes.
        frames: the frames of the model.
        version: the version of the file.
        reading: the context of the reading.

    Raises:
        SceneError: a gearbox names a part that does not exist.
    """
    rows = list(rows)
    for gearbox in model.all("joint"):
        if gearbox.attribute("type") != "gearbox":
            continue
        name, body = gearbox.attribute("name"), gearbox.find("gearbox_reference_body")
        if body is None:
            what = "it has no <gearbox_reference_body>"
            reading.notes.warn(
                gearbox, Code.NRP260, f"the gearbox '{name}' is left out: {what}", subject=name
            )
            continue
        reference = _link(body, frames)
        held = {row[0].child: row for row in rows}
        ends = [
            _turning(
                held,
                reference,
                _link(gearbox.require(end), frames),
                direction(gearbox, axis, frames, version),
            )
            for end, axis in (("parent", "axis"), ("child", "axis2"))
        ]
        (driving, one), (driven, other) = ends
        if driving is None or driven is None or driving == driven or driven.mimic is not None:
            what = (
                "its parent and child do not each turn by one joint of their own against the reference body"
            )
            reading.notes.warn(
                gearbox, Code.NRP260, f"the gearbox '{name}' is left out: {what}", subject=name
            )
            continue
        follows = Mimic(driving.name, -gearbox.number("gearbox_ratio", 1.0) * one * other)
        rows = [tuple(replace(j, mimic=follows) if j == driven else j for j in row) for row in rows]
    return rows


def _turning(
    held: Mapping[str, Row], reference: str, link: str, axis: tuple[float, float, float]
) -> tuple[Joint | None, float]:
    """Return the single joint by which a link turns against a body about an axis, and its sense (1, -1).

    The joint is None if there is no such joint.
    """
    above, below = list(_holding(held, reference)), list(_holding(held, link))
    parting = [(1.0, row) for row in below if row not in above]
    parting += [(-1.0, row) for row in above if row not in below]
    moving = [(sense, joint) for sense, row in parting for joint in row if joint.kind != "fixed"]
    if len(moving) != 1:
        return None, 0.0
    sense, joint = moving[0]
    along = float(np.dot(Pose(orientation=joint.pose.orientation).rotate(joint.axis), axis))
    turns = joint.kind in ("revolute", "continuous") and abs(along) > 1 - _ROUNDING
    return (joint, sense if along > 0 else -sense) if turns else (None, 0.0)


def _holding(held: Mapping[str, Row], link: str) -> Iterator[Row]:
    """Yield the joints that hold a link, from there upwards; those in a loop once."""
    seen = set()
    while link in held and link not in seen:
        seen.add(link)
        yield held[link]
        link = held[link][0].parent


def _link(element: Element, frames: Frames) -> str:
    return WORLD if element.text == WORLD else frames.body(element.text, element)
