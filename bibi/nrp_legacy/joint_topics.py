"""Joints that functions command by topics of the platform, though no plugin that is known here serves them.

Robots of the platform had plugins of their own for it. Whatever they were, ``/robot/joint/cmd_pos`` and
``/icub/joint/vel`` say which joint is meant and how.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Literal

from nrp_core.world.scene.acting import JointController
from nrp_core.world.scene.model import Model

Kind = Literal["position", "velocity"]

_TOPIC = re.compile(r"""["'](/[\w/-]*?/(?P<joint>[\w-]+)/(?P<end>cmd_pos|cmd_vel|pos|vel))/?["']""")
_KINDS: dict[str, Kind] = {
    "cmd_pos": "position",
    "pos": "position",
    "cmd_vel": "velocity",
    "vel": "velocity",
}


def with_commanded_joints(model: Model, sources: Iterable[str]) -> Model:
    """Return a robot with a controller for each of its joints that some code commands by its name.

    Args:
        model: the robot.
        sources: the code of the transfer functions.
    """
    free = {joint.name for joint in model.joints if joint.kind != "fixed"}
    driven = {(controller.joint, controller.kind) for controller in model.controllers}
    added = [
        JointController(joint, kind, topic, gains=None)
        for topic, joint, kind in dict.fromkeys(_commands(sources))
        if joint in free and (joint, kind) not in driven
    ]
    return replace(model, controllers=(*model.controllers, *added)) if added else model


def _commands(sources: Iterable[str]) -> Iterator[tuple[str, str, Kind]]:
    for source in sources:
        for found in _TOPIC.finditer(source):
            yield found[1], found["joint"], _KINDS[found["end"]]
