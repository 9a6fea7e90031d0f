"""Values of an MJCF file that MuJoCo accepts, but that are probably mistakes or have no equal in a scene."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any, Final

from nrp_core.errors import SceneError
from nrp_core.findings import Code, Findings
from nrp_core.world.rigid import ROUNDED_TURN_RAD
from nrp_core.world.scene.reading.context import Element
from nrp_world_mujoco.actuators import actuators_of
from nrp_world_mujoco.library import mujoco

_RIGHT_ANGLES_RAD: Final = (pi / 4, pi / 2, pi, 3 * pi / 2)
_ROUNDED: Final = 2e-3
_LEAST_SHARE: Final = 0.01
"""The least range of a servo, in ranges of its joint, with which one sees that it moves."""
_RANGES: Final = ("range", "forcerange", "ctrlrange", "actuatorfrcrange")
_HINGED: Final = ("", "hinge")
_TURNS_RAD: Final = 4 * pi
"""Two turns: a joint with limits turns less."""
_HEAVIEST: Final = 1e4
"""Of an armature, in inertias of the links that it turns; a gear of 100 to 1 has some thousands."""


def warn_of_slips(root: Element, model: Any, warnings: Findings) -> None:
    """Warn of angles in the other unit, ranges whose ends are exchanged, and forces that a scene lacks.

    Args:
        root: the root of an MJCF file; the files that it includes are not looked at.
        model: the compiled model.
        warnings: receives the findings.
    """
    elements = list(_all(root))
    actuators = [one for group in root.all("actuator") for one in group.children]
    for owners, found in (
        (actuators, (*_one_sided(model), *_without_effect(model), *_rivals(model))),
        (elements, _armatures(model)),
    ):
        for code, name, message in found:
            named = (
                one for one in owners if name in (one.attributes.get("name"), one.attributes.get("joint"))
            )
            place = next(named, root)
            warnings.add(code, message, path=place.path, line=place.line)
    units = [one.attributes.get("angle") for one in elements if one.tag == "compiler"]
    in_degrees = "radian" not in units
    for element in elements:
        for message in (*_orientation(element, in_degrees), *_exchanged(element), *_narrow(element)):
            warnings.add(Code.NRP298, message, path=element.path, line=element.line)
    if in_degrees:
        _warn_of_limits(elements, warnings)


def _all(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        yield from _all(child)


def _numbers(element: Element, attribute: str) -> tuple[float, ...]:
    """Return the numbers of an attribute; none if it is missing, or refused by MuJoCo."""
    text = element.attributes.get(attribute, "")
    try:
        return element.parse_numbers(text, len(text.split())) if text.strip() else ()
    except SceneError:
        return ()


def _named(element: Element) -> str:
    name = element.attributes.get("name")
    return f"<{element.tag}>" + (f" '{name}'" if name else "")


def _orientation(element: Element, in_degrees: bool) -> Iterator[str]:
    given = _numbers(element, "euler")
    owner = f"the euler of the {_named(element)} is {element.attributes.get('euler')}"
    if not in_degrees and any(abs(angle) > ROUNDED_TURN_RAD for angle in given):
        yield f"{owner} rad, more than a turn; is it meant in degrees?"
    elif in_degrees and any(
        abs(abs(angle) - right) < _ROUNDED for angle in given for right in _RIGHT_ANGLES_RAD
    ):
        yield f'{owner} degrees; is it meant in radians? Then the file needs <compiler angle="radian"/>'


def _exchanged(element: Element) -> Iterator[str]:
    for name in _RANGES:
        ends = _numbers(element, name)
        if len(ends) == 2 and ends[0] > ends[1]:
            yield f"the {name} of the {_named(element)} begins at {ends[0]:g} and ends at {ends[1]:g}"


def _narrow(element: Element) -> Iterator[str]:
    """Yield the angles of cameras that are right in radians only."""
    fovy = next(iter(_numbers(element, "fovy")), 0.0) if element.tag == "camera" else 0.0
    if 0 < fovy <= pi:
        yield f"the fovy of the {_named(element)} is {fovy:g}: it is in degrees, also in a file in radians"


def _warn_of_limits(elements: list[Element], warnings: Findings) -> None:
    """Warn if no hinge of a file in degrees moves by more than a full turn in radians."""
    hinges = [one for one in elements if one.tag == "joint" and one.attributes.get("type", "") in _HINGED]
    limited = [(one, ends) for one in hinges if (ends := _numbers(one, "range")) and any(ends)]
    if limited and all(abs(end) <= ROUNDED_TURN_RAD for _, ends in limited for end in ends):
        first, ends = limited[0]
        message = (
            f"the {_named(first)} has a range of {' to '.join(f'{end:g}' for end in ends)} degrees, and no "
            f"joint of the file one of more than {ROUNDED_TURN_RAD:.2g}; are they radians? Then it needs "
            '<compiler angle="radian"/>'
        )
        warnings.add(Code.NRP298, message, path=first.path, line=first.line)


def _one_sided(model: Any) -> Iterator[tuple[Code, str, str]]:
    """Yield the actuators of joints whose force has another limit in each direction."""
    for each in actuators_of(model):
        actuator, joint = model.actuator(each.number).name, model.joint(each.joint).name
        low, high = model.actuator_forcerange[each.number].tolist()
        if model.actuator_forcelimited[each.number] and low != -high:
            yield (
                Code.NRP264,
                actuator or joint,
                f"the forcerange of the actuator of the joint '{joint}' is {low:g} to {high:g}, and joints "
                f"have one limit for both directions: the limit used is {max(abs(low), abs(high)):g}",
            )


def _armatures(model: Any) -> Iterator[tuple[Code, str, str]]:
    """Yield the armatures that are negative, or far beyond the inertia of the links that they turn."""
    for joint in range(model.njnt):
        dof, name = int(model.jnt_dofadr[joint]), model.joint(joint).name
        armature = float(model.dof_armature[dof])
        links = float(model.dof_M0[dof]) - armature
        if armature < 0:
            yield (
                Code.NRP298,
                name,
                f"the armature of the joint '{name}' is {armature:g}: an inertia is above 0",
            )
        elif armature > _HEAVIEST * links > 0:
            yield (
                Code.NRP298,
                name,
                f"the armature of the joint '{name}' is {armature:g}, {armature / links:.2g} times the "
                f"inertia of the links that it turns ({links:.2g}): commands hardly move it",
            )


def _without_effect(model: Any) -> Iterator[tuple[Code, str, str]]:
    """Yield the actuators of joints that do nothing, drive away from their target, or take degrees."""
    for number in range(model.nu):
        actuator = model.actuator(number)
        if mujoco.mjtTrn(model.actuator_trntype[number]) != mujoco.mjtTrn.mjTRN_JOINT:
            continue
        joint, gear = int(actuator.trnid[0]), float(actuator.gear[0])
        gain, spring = float(actuator.gainprm[0]), float(actuator.biasprm[1])
        name = actuator.name or model.joint(joint).name
        owner = f"the actuator '{name}' of the joint '{model.joint(joint).name}'"
        if not actuator.gear.any():
            yield Code.NRP298, name, f"the gear of {owner} is 0: it moves nothing"
        elif not actuator.gainprm.any():
            yield Code.NRP298, name, f"the gain (kp) of {owner} is 0: its commands move nothing"
        elif gain == -spring > 0 and (beyond := _unreached(model, number, joint, gear)):
            yield Code.NRP298, name, f"the ctrlrange of {owner} {beyond}"
        elif gain == -spring < 0:
            yield (
                Code.NRP298,
                name,
                f"the kp of {owner} is {gain:g}: it drives the joint away from its target",
            )
        elif gain == -spring > 0 and model.actuator_ctrllimited[number] and model.jnt_limited[joint]:
            widest_rad = float(abs(actuator.ctrlrange).max() / abs(gear)) if gear else 0.0
            is_hinge = mujoco.mjtJoint(model.jnt_type[joint]) == mujoco.mjtJoint.mjJNT_HINGE
            if is_hinge and float(abs(model.jnt_range[joint]).max()) < _TURNS_RAD < widest_rad:
                low, high = (float(end) for end in actuator.ctrlrange)
                yield (
                    Code.NRP298,
                    name,
                    f"the ctrlrange of {owner} is {low:g} to {high:g}, far beyond the range of the joint; "
                    "it is in radians, also in a file in degrees",
                )
            elif is_hinge and widest_rad < _LEAST_SHARE * float(abs(model.jnt_range[joint]).max()):
                low, high = (float(end) for end in actuator.ctrlrange)
                yield (
                    Code.NRP298,
                    name,
                    f"the ctrlrange of {owner} is {low:g} to {high:g} rad, and the joint turns by up to "
                    f"{float(abs(model.jnt_range[joint]).max()):.3g} rad",
                )


def _rivals(model: Any) -> Iterator[tuple[Code, str, str]]:
    """Yield the servos that hold a joint beside another one, each at a target of its own."""
    servos: dict[tuple[int, int], str] = {}
    for number in range(model.nu):
        actuator = model.actuator(number)
        gain, stiffness, damping = actuator.gainprm[0], -actuator.biasprm[1], -actuator.biasprm[2]
        term = 1 if gain == stiffness > 0 else 2 if gain == damping > 0 else 0
        if not term or mujoco.mjtTrn(model.actuator_trntype[number]) != mujoco.mjtTrn.mjTRN_JOINT:
            continue
        joint = int(actuator.trnid[0])
        first = servos.setdefault((joint, term), actuator.name)
        if first != actuator.name:
            what = "position" if term == 1 else "velocity"
            yield (
                Code.NRP298,
                actuator.name,
                f"two servos drive the {what} of the joint '{model.joint(joint).name}', '{first}' and "
                f"'{actuator.name}': each pulls it to its own target, which is 0 without a command",
            )


def _unreached(model: Any, number: int, joint: int, gear: float) -> str:
    """Return that no position a servo takes is within the range of its joint; empty if some are."""
    if not (model.actuator_ctrllimited[number] and model.jnt_limited[joint] and gear):
        return ""
    low, high = sorted(float(end) / gear for end in model.actuator_ctrlrange[number])
    least, most = model.jnt_range[joint].tolist()
    if least <= high and low <= most:
        return ""
    return (
        f"is {low:g} to {high:g}, and the range of the joint {least:.3g} to {most:.3g}: it stays at one end"
    )
