"""The elements and attributes of URDF (http://wiki.ros.org/urdf/XML), to find misspelt ones.

Files hold many others, for other programs. So only those are reported that resemble a name of URDF, or that
stand alone in an element that holds attributes only.
"""

from __future__ import annotations

from difflib import get_close_matches
from typing import Final

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element

_SHAPES: Final = "box cylinder sphere mesh capsule plane"
_TABLE: Final = {
    "robot": ("name version", ""),  # its children are checked where they are converted
    "link": ("name type", "inertial visual collision contact"),
    "inertial": ("", "origin mass inertia"),
    "mass": ("value", ""),
    "inertia": ("ixx iyy izz ixy ixz iyz", ""),
    "origin": ("xyz rpy quat_xyzw", ""),
    "visual": ("name", "origin geometry material"),
    "collision": ("name", "origin geometry"),
    "geometry": ("", _SHAPES),
    "box": ("size", ""),
    "cylinder": ("radius length", ""),
    "sphere": ("radius", ""),
    "capsule": ("radius length", ""),
    "mesh": ("filename scale", ""),
    "material": ("name", "color texture"),
    "color": ("rgba", ""),
    "joint": ("name type", "origin parent child axis calibration dynamics limit mimic safety_controller"),
    "parent": ("link", ""),
    "child": ("link", ""),
    "axis": ("xyz", ""),
    "dynamics": ("damping friction", ""),
    "limit": ("lower upper effort velocity acceleration deceleration jerk", ""),
    "mimic": ("joint multiplier offset", ""),
    "safety_controller": ("soft_lower_limit soft_upper_limit k_position k_velocity", ""),
}
"""Attributes and children by element."""
_KNOWN: Final = {
    tag: (frozenset(attributes.split()), frozenset(children.split()))
    for tag, (attributes, children) in _TABLE.items()
}
_ELSEWHERE: Final = {name: tag for tag in ("origin", "dynamics", "limit") for name in _TABLE[tag][0].split()}
"""Attributes that only one element has."""
_FREE: Final = ("gazebo", "transmission", "ros2_control", "sensor", "contact")
_HARMLESS: Final = {("collision", "material")}
"""What exporters write in vain: a collision is not seen."""
_ALIKE: Final = 0.6
_LOWEST, _HIGHEST = "soft_lower_limit", "soft_upper_limit"


def check_vocabulary(element: Element, notes: Notes) -> None:
    """Warn of misspelt attributes and elements of a robot, which would be ignored in silence."""
    attributes, children = _KNOWN.get(element.tag, (frozenset(), frozenset()))
    for name in sorted(element.attributes.keys() - attributes):
        if name in _ELSEWHERE:
            continue
        alone = not children and not attributes & element.attributes.keys()
        if (
            attributes
            and ":" not in name
            and (alone or _resembles(name, attributes - element.attributes.keys()))
        ):
            hint = did_you_mean(name, attributes)
            message = f"<{element.tag}> has no attribute '{name}': ignored{hint}"
            notes.warn(element, Code.NRP263, message, subject=name)
    for name in sorted((element.attributes.keys() & _ELSEWHERE.keys()) - attributes if attributes else ()):
        message = f"<{element.tag}> has no attribute '{name}': ignored; it belongs in <{_ELSEWHERE[name]}>"
        notes.warn(element, Code.NRP263, message, subject=name)
    text = element.text.strip()
    if text and element.tag in _KNOWN:
        written = f'; write {next(iter(_TABLE[element.tag][0].split()))}="{text}"' if attributes else ""
        message = (
            f"the text '{text:.30}' in <{element.tag}> is ignored: URDF has values in attributes{written}"
        )
        notes.warn(element, Code.NRP263, message, subject=element.tag)
    if element.tag == "safety_controller":
        _check_soft_limits(element, notes)
    for child in element.children:
        if children and child.tag not in children and ":" not in child.tag:
            _check_misplaced(child, element, children, notes)
        if child.tag not in _FREE and child.tag in _KNOWN:
            check_vocabulary(child, notes)


def _check_misplaced(child: Element, parent: Element, valid: frozenset[str], notes: Notes) -> None:
    """Warn of an element that its parent does not have: a misspelt one, or one of another element."""
    holders = [f"<{tag}>" for tag, (_, children) in _KNOWN.items() if child.tag in children]
    if holders and (parent.tag, child.tag) not in _HARMLESS:
        hint = f"; it belongs in {' or '.join(holders)}"
    elif not holders and _resembles(child.tag, valid):
        hint = did_you_mean(child.tag, valid)
    else:
        return
    message = f"URDF has no <{child.tag}> in a <{parent.tag}>: ignored{hint}"
    notes.warn(child, Code.NRP263, message, subject=child.tag)


def _resembles(name: str, known: frozenset[str]) -> bool:
    return bool(get_close_matches(name, known, n=1, cutoff=_ALIKE))


def _check_soft_limits(element: Element, notes: Notes) -> None:
    """Warn of soft limits that exclude every position; correct ones have no effect in a simulation either."""
    low, high = (
        element.parse_numbers(element.attributes.get(name, "0"), 1)[0] for name in (_LOWEST, _HIGHEST)
    )
    if low > high:
        message = (
            f"the {_LOWEST} of a <safety_controller>, {low:g}, is above its {_HIGHEST}, {high:g}; "
            "no safety controller is simulated"
        )
        notes.warn(element, Code.NRP263, message, subject="safety_controller")
