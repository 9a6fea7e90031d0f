"""The actuators of an MJCF file that drive a single joint, as equivalent joint controllers.

MuJoCo's actuator gives ``gain * ctrl + b0 + b1 * length + b2 * velocity``, times its gear, where the length
is the joint's position times its gear: a motor, a spring towards a position, or a brake towards a
velocity. See
https://mujoco.readthedocs.io/en/stable/computation/index.html#actuation-model.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, Literal

from nrp_core.findings import Code, Findings
from nrp_core.scene.reading.context import Element
from nrp_core.world.controllers.plugins import RANGE
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.schema import stated

SINGLE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_PLAIN = (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
LAW = ("biasprm", "biastype", "ctrllimited", "ctrlrange", "dynprm", "dyntype", "forcelimited", "forcerange",
       "gainprm", "gaintype", "gear", "inheritrange")  # fmt: skip
"""Attributes that the compiled model has in another way."""
_OF_CONTROLLER = (*LAW, "actearly", "actlimited", "actrange", "cranklength", "group", "input", "user")
"""Attributes that a joint controller has, or without effect on it."""
_SYSTEMS = {"position": "JointPositionController", "velocity": "JointController", "effort": "ApplyJointForce"}
_TOPICS = {"position": "cmd_pos", "velocity": "cmd_vel", "effort": "cmd_effort"}


@dataclass(frozen=True, slots=True)
class Actuator:
    """The effect of an actuator on its joint.

    Args:
        number: number of the actuator.
        joint: number of the joint.
        kind: the commanded quantity.
        p, d: force (N, N m) for each unit of the command, and against each unit of velocity.
        force: the maximum force.
        range: the minimum and maximum of commands.
    """

    number: int
    joint: int
    kind: Literal["position", "velocity", "effort"]
    p: float
    d: float
    force: float
    range: tuple[float, float]

    def plugin(self, joint: str, zero: float) -> str:
        """Return it as the equivalent system of gz-sim.

        Args:
            joint: name of the joint.
            zero: MuJoCo's zero position, which is the target before the first command.
        """
        lower, upper = self.range
        if self.kind == "position":
            lower, upper = lower + zero, upper + zero
        limits = f"<{RANGE}>{lower} {upper}</{RANGE}>"
        first = min(max(0.0 if self.kind == "velocity" else zero, lower), upper)
        gains = f"<p_gain>{self.p}</p_gain><i_gain>0</i_gain><d_gain>{self.d}</d_gain>"
        start = {
            "position": f"<initial_position>{first}</initial_position>",
            "velocity": f"<initial_velocity>{first}</initial_velocity>"
            "<use_force_commands>1</use_force_commands>",
            "effort": "",
        }[self.kind]
        return (
            f'<plugin name="gz::sim::systems::{_SYSTEMS[self.kind]}" filename="mjcf">'
            f"<joint_name>{joint}</joint_name><topic>{joint}/{_TOPICS[self.kind]}</topic>{gains}{limits}{start}</plugin>"
        )


def actuators_of(spec: Any, model: Any) -> list[Actuator]:
    """Return the actuators that are joint controllers, one for each joint.

    If a joint has several, its controller is the first position servo, or else the first actuator. The others
    are not controllers: of these only the last commanded one acts, but the forces of actuators add up.

    Args:
        spec: the specification that MuJoCo read.
        model: the compiled model.
    """
    usual = mujoco.MjSpec().add_actuator()
    plain = [each.id for each in spec.actuators if not stated(each, usual, "general", _OF_CONTROLLER)]
    found = [actuator for actuator in (_read(model, number) for number in plain) if actuator is not None]
    chosen: dict[int, Actuator] = {}
    for actuator in sorted(found, key=lambda each: each.kind != "position"):
        chosen.setdefault(actuator.joint, actuator)
    return [actuator for actuator in found if chosen[actuator.joint] is actuator]


def _read(m: Any, number: int) -> Actuator | None:
    """Return the controller that is equivalent to an actuator, or None."""
    joint, gear = int(m.actuator_trnid[number][0]), float(m.actuator_gear[number][0])
    on_joint = mujoco.mjtTrn(m.actuator_trntype[number]) == mujoco.mjtTrn.mjTRN_JOINT
    gain = float(m.actuator_gainprm[number][0])
    if not on_joint or mujoco.mjtJoint(m.jnt_type[joint]) not in SINGLE or not gear * gain:
        return None
    plain = (
        mujoco.mjtDyn(m.actuator_dyntype[number]) == mujoco.mjtDyn.mjDYN_NONE
        and mujoco.mjtGain(m.actuator_gaintype[number]) == mujoco.mjtGain.mjGAIN_FIXED
        and mujoco.mjtBias(m.actuator_biastype[number]) in _PLAIN
    )
    if not plain:
        return None
    control = int(m.actuator_ctrladr[number])
    constant, spring, brake = (float(value) for value in m.actuator_biasprm[number][:3])
    force = (
        abs(gear) * float(abs(m.actuator_forcerange[number]).max())
        if m.actuator_forcelimited[number]
        else inf
    )
    clamps = (
        m.actuator_ctrllimited[control] and not m.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL
    )
    low, high = m.actuator_ctrlrange[control].tolist() if clamps else (-inf, inf)
    if (constant, spring, brake) == (0, 0, 0):
        efforts = _scaled(low, high, gear * gain)
        if not low <= 0 <= high:  # a joint without commands would have a force
            return None
        force = min(force, max(map(abs, efforts)))
        return Actuator(number, joint, "effort", 0.0, 0.0, force, efforts)
    commands = _scaled(low, high, 1 / gear)
    if constant == 0 and gain == -spring > 0:
        return Actuator(number, joint, "position", gear**2 * gain, gear**2 * -brake, force, commands)
    if (constant, spring) == (0, 0) and gain == -brake > 0:
        return Actuator(number, joint, "velocity", gear**2 * gain, 0.0, force, commands)
    return None


def _scaled(low: float, high: float, scale: float) -> tuple[float, float]:
    one, other = low * scale, high * scale
    return min(one, other), max(one, other)


def warn_of_one_sided_limits(root: Element, spec: Any, model: Any, warnings: Findings) -> None:
    """Warn of actuators of joints whose force has another limit in each direction.

    Args:
        root: the root of the MJCF file.
        spec: the specification that MuJoCo read.
        model: the compiled model.
        warnings: receives the findings.
    """
    elements = [one for group in root.all("actuator") for one in group.children]
    for each in actuators_of(spec, model):
        low, high = model.actuator_forcerange[each.number].tolist()
        if not model.actuator_forcelimited[each.number] or low == -high:
            continue
        name, joint = model.actuator(each.number).name, model.joint(each.joint).name
        message = (
            f"the forcerange of the actuator of the joint '{joint}' is {low:g} to {high:g}, and joints have "
            f"one limit for both directions: the limit used is {max(abs(low), abs(high)):g}"
        )
        named = (one for one in elements if (name or joint) in _names(one))
        place = next(named, root)
        warnings.add(Code.NRP264, message, path=place.path, line=place.line)


def _names(actuator: Element) -> tuple[str | None, str | None]:
    """Return the name of an actuator, and of the joint that it drives."""
    return actuator.attributes.get("name"), actuator.attributes.get("joint")
