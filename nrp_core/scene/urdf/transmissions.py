"""The tags of ros_control and ros2_control: the command interfaces of joints.

A URDF does not name the controllers that a robot loads. Here each interface has its own topic:
``/<robot>/<joint>/cmd_pos``, ``cmd_vel`` or ``cmd_effort``. Joints with positions or efforts also follow
trajectories, on ``/<robot>/joint_trajectory_controller/command``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from nrp_core.errors import did_you_mean, hint_if_close
from nrp_core.findings import Code
from nrp_core.scene.reading.context import Element, Notes
from nrp_core.scene.urdf.elements import new

START = "initial_position"
"""The element with the start of a joint: of an ``<axis>`` in SDF, here also of a joint of a URDF."""
_NAME = "ros_control"
_PACKAGE = "hardware_interface"
_KINDS = {
    "PositionJointInterface": "position",
    "VelocityJointInterface": "velocity",
    "EffortJointInterface": "effort",
}


def read_transmission(transmission: Element, joints: Collection[str], notes: Notes) -> Iterator[Element]:
    """Yield a plugin with a controller for each interface of each joint of a ``<transmission>``.

    Args:
        transmission: the element.
        joints: names of the joints of the robot.
        notes: receives warnings, also of joints that the robot does not have.
    """
    name = transmission.attributes.get("name", "")
    actuators = transmission.all("actuator")
    for one in (each for owner in (transmission, *actuators) for each in owner.all("mechanicalReduction")):
        if one.text.strip("+-0. ") == "":
            message = f"a <mechanicalReduction> of {one.text!r} is impossible: ignored, as all are"
            notes.warn(one, Code.NRP383, message, subject=name)
    if not transmission.all("joint"):
        message = f"the <transmission> '{name}' has no <joint>, so that it commands nothing"
        notes.warn(transmission, Code.NRP265, message, subject=name, alike="no joint")
    for joint in transmission.all("joint"):
        if (joint_name := joint.attribute("name")) not in joints:
            message = f"the <transmission> '{name}' is of a joint '{joint_name}' that the model does not have"
            hint = did_you_mean(joint_name, joints)
            message += f"{hint}: it commands nothing"
            notes.warn(joint, Code.NRP265, message, subject=joint_name, alike="transmission without joint")
            continue
        # older files have the interface in the actuator
        named = joint.all("hardwareInterface") or [
            each for actuator in actuators for each in actuator.all("hardwareInterface")
        ]
        for interface in named:
            package, _, name = interface.text.rpartition("/")
            kind = _KINDS.get(name) if package in ("", _PACKAGE) else None
            if kind is None:
                correction = hint_if_close(
                    interface.text, [f"{_PACKAGE}/{one}" for one in _KINDS] if package else _KINDS
                )
                message = f"joints cannot be commanded by '{interface.text}'{correction}"
                notes.warn(interface, Code.NRP265, message, subject=interface.text)
            else:
                yield _controller(joint, interface, kind)


def read_ros2_control(system: Element, notes: Notes) -> Iterator[Element]:
    """Yield a plugin with a controller for each command interface of a ``<ros2_control>``."""
    for joint in system.all("joint"):
        for interface in joint.all("command_interface"):
            kind = interface.attribute("name")
            if kind in _KINDS.values():
                yield _controller(joint, interface, kind)
            else:
                notes.warn(interface, Code.NRP265, f"joints cannot be commanded by '{kind}'", subject=kind)


def give_parameters(robot: Element) -> Mapping[str, Element]:
    """Apply the parameters of a ``<ros2_control>`` to its joints; return the joints by name.

    These are the joint that it mimics, unless it has a ``<mimic>``, and its initial position.
    """
    joints = {joint.attribute("name"): joint for joint in robot.all("joint")}
    for described in (each for system in robot.all("ros2_control") for each in system.all("joint")):
        joint = joints.get(described.attribute("name"))
        if joint is not None:
            joint.children += [*_mimic_elements(described, joint), *_start_elements(described)]
    return joints


def _mimic_elements(described: Element, joint: Element) -> Iterator[Element]:
    given = _parameters(described)
    if "mimic" in given and not joint.all("mimic"):
        factor = given["multiplier"].text if "multiplier" in given else "1"
        yield new("mimic", given["mimic"], joint=given["mimic"].text, multiplier=factor)


def _start_elements(described: Element) -> Iterator[Element]:
    for state in described.all("state_interface"):
        given = _parameters(state)
        if state.attribute("name") == "position" and "initial_value" in given:
            yield new(START, given["initial_value"], text=given["initial_value"].text)


def _parameters(element: Element) -> Mapping[str, Element]:
    return {param.attribute("name"): param for param in element.all("param")}


def trajectory_plugins(model: Element) -> Iterator[Element]:
    """Yield a plugin with a trajectory controller of the joints for which controllers were created."""
    plugins = [each for each in model.all("plugin") if each.attributes.get("name") == _NAME]
    controllers = [each for plugin in plugins for each in plugin.all("controller")]
    names = dict.fromkeys(
        each.attribute("joint_name") for each in controllers if each.word("type") != "velocity"
    )
    if names:
        topics = (
            new(tag, model, text=f"joint_trajectory_controller/{end}")
            for tag, end in (("topic", "command"), ("state_topic", "state"))
        )
        joints = (new("joint_name", model, text=name) for name in names)
        file = "gz-sim-joint-trajectory-controller-system"
        yield new("plugin", model, *joints, *topics, name="joint_trajectory_controller", filename=file)


def _controller(joint: Element, interface: Element, kind: str) -> Element:
    named = joint.attribute("name")
    controller = new("controller", joint, new("type", interface, text=kind), joint_name=named)
    return new("plugin", joint, controller, name=_NAME, filename="libgeneric_controller_plugin.so")
