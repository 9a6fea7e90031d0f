"""The plugins by which robots in Gazebo Classic couple joints, which had no ``<mimic>``."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.world.scene.model import Mimic
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import name_of_file
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.compound import Row

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
