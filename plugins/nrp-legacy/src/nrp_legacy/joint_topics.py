"""Joints commanded by topics of the platform for which there is no known plugin.

Robots of the platform had their own plugins for it, or the controllers of ``ros_control``. In either case
``/robot/joint/cmd_pos``, ``/icub/joint/vel``, ``/arm/joint_position_controller/command`` and
``/joint_pos_cntr/command`` name the joint and the quantity.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from typing import Literal

from nrp_core.findings import Code, Finding
from nrp_core.world.scene.devices import JointController, TrajectoryController
from nrp_core.world.scene.model import Model

Kind = Literal["position", "velocity", "effort"]

_PLACE = r"%[sd]|\{\w*\}|[\"']\s*\+[^\"'\n]*\+\s*[\"']"
"""Where code puts a name, or a part of one, in."""
_JOINT = rf"(?P<joint>(?:[\w-]|{_PLACE})+?)"
"""The name of a joint."""
_LEAD = rf"(?P<lead>(?:(?:[\w-]|{_PLACE})+/)*)"
"""What comes before it: the name of the robot, perhaps, which code may put in."""
_TOPIC = re.compile(rf"""["']/?{_LEAD}{_JOINT}(?P<end>/(?:cmd_)?(?:pos|vel|effort|torque))/?["']""")
_CONTROLLER = re.compile(
    rf"""["']/?{_LEAD}{_JOINT}"""
    r"""(?P<end>(?:_(?:position|velocity|effort|pos|vel))?_(?:controller|cntr)/command)["']"""
)
_TRAJECTORY = re.compile(r"""["']/?(?P<topic>[\w/-]+)["']\s*,\s*(?:\w+\s*=\s*)?(?:\w+\.)*JointTrajectory\b""")
"""A topic with its type, as publishers are made."""
_KINDS: dict[str, Kind] = {"vel": "velocity", "eff": "effort", "tor": "effort"}


def with_commanded_joints(model: Model, sources: Iterable[str], others: Collection[str] = ()) -> Model:
    """Return a robot with a controller for each of its joints that some code commands by its name.

    Topics of trajectories command all of its joints.

    Args:
        model: the robot.
        sources: the code of the transfer functions and state machines.
        others: the names of other robots; topics that begin with one are not for this robot.
    """
    free = {joint.name for joint in model.joints if joint.takes_commands}
    driven = {(controller.joint, controller.kind) for controller in model.controllers}
    served = {controller.topic for controller in model.controllers}
    sources = list(sources)
    followers = (*model.trajectory_controllers, *_followers(model, sources, sorted(free), others))
    served |= {follower.command_topic for follower in followers}
    added = [
        JointController(joint, kind, topic, gains=None)
        for topic, joint, kind in dict.fromkeys(_commands(model.name, sources, sorted(free)))
        if (joint, kind) not in driven and topic not in served and topic.split("/")[1] not in others
    ]
    controllers = (*model.controllers, *added)
    warnings = tuple(
        warning for warning in model.warnings if not ((controllers or followers) and _is_served(warning))
    )
    return replace(model, controllers=controllers, trajectory_controllers=followers, warnings=warnings)


def _is_served(warning: Finding) -> bool:
    """Return whether a warning is about the plugin that these controllers replace."""
    return warning.code is Code.NRP261 and warning.subject == "gazebo_ros_control"


def _followers(
    model: Model, sources: Iterable[str], joints: Collection[str], others: Collection[str]
) -> Iterator[TrajectoryController]:
    """Yield a controller for each topic of trajectories in some code that the file does not have."""
    taken = {follower.command_topic for follower in model.trajectory_controllers}
    found = dict.fromkeys(each["topic"] for source in sources for each in _TRAJECTORY.finditer(source))
    for topic in found if joints else ():
        if f"/{topic}" not in taken and topic.split("/")[0] not in others:
            yield TrajectoryController(topic, f"/{topic}", tuple(joints))


def _commands(model: str, sources: Iterable[str], joints: Collection[str]) -> Iterator[tuple[str, str, Kind]]:
    """Yield the topics in some code, with the joints that they name; all joints if the name is computed.

    A computed name before it is taken for the robot's.
    Joints that trajectories move get their own topics, so that they hold their positions.
    """
    for source in sources:
        if "JointTrajectory" in source:
            for joint in joints:
                if re.search(rf"""["'](?:[\w-]+::)*{re.escape(joint)}["']""", source):
                    yield f"/{model}/{joint}/cmd_pos", joint, "position"
        for found in (*_TOPIC.finditer(source), *_CONTROLLER.finditer(source)):
            named = re.compile(re.sub(_PLACE, r"[\\w-]+", found["joint"]))
            lead = re.sub(_PLACE, model, found["lead"])
            for joint in filter(named.fullmatch, joints):
                yield f"/{lead}{joint}{found['end']}", joint, _kind(found["end"])


def _kind(end: str) -> Kind:
    return next((kind for part, kind in _KINDS.items() if part in end), "position")
