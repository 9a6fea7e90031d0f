"""The tags of ros_control and ros2_control: which joints of a robot can be commanded, and how.

Which controllers a robot loads stands outside of its URDF; here each interface takes commands by itself, as
directly as it can: ``/<robot>/<joint>/cmd_pos``, ``cmd_vel`` or ``cmd_effort``.
"""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.world.scene.reading import Notes
from nrp_core.world.scene.urdf.elements import new
from nrp_core.world.scene.xml_tree import Element

_KINDS = {
    "PositionJointInterface": "position",
    "VelocityJointInterface": "velocity",
    "EffortJointInterface": "effort",
}


def transmitted(transmission: Element, notes: Notes) -> Iterator[Element]:
    """Yield a plugin with a controller for each interface of each joint of a ``<transmission>``."""
    for joint in transmission.all("joint"):
        # older files name the interface beside the actuator
        named = joint.all("hardwareInterface") or [
            each for actuator in transmission.all("actuator") for each in actuator.all("hardwareInterface")
        ]
        for interface in named:
            kind = _KINDS.get(interface.text.rpartition("/")[2])
            if kind is None:
                notes.warn(interface, f"joints cannot be commanded by '{interface.text}'")
            else:
                yield _controller(joint, interface, kind)


def controlled(system: Element, notes: Notes) -> Iterator[Element]:
    """Yield the same for each command interface of a ``<ros2_control>``."""
    for joint in system.all("joint"):
        for interface in joint.all("command_interface"):
            kind = interface.attribute("name")
            if kind in _KINDS.values():
                yield _controller(joint, interface, kind)
            else:
                notes.warn(interface, f"joints cannot be commanded by '{kind}'")


def _controller(joint: Element, interface: Element, kind: str) -> Element:
    named = joint.attribute("name")
    controller = new("controller", joint, new("type", interface, text=kind), joint_name=named)
    return new("plugin", joint, controller, name="ros_control", filename="libgeneric_controller_plugin.so")
