"""Gearboxes of SDF: joints that do not hold a link but make one joint follow another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Joint, Mimic
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.axes import direction
from nrp_core.world.scene.sdf.compound import Row
from nrp_core.world.scene.sdf.frames import Frames

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
