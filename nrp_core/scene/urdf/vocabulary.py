"""The elements and attributes of URDF (http://wiki.ros.org/urdf/XML), to find misspelt ones.

Files hold many others, for other programs. So only those are reported that resemble a name of URDF, or that
stand alone in an element that holds attributes only.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches
from typing import Final

from nrp_core.errors import SceneError, did_you_mean, hint_if_close
from nrp_core.findings import Code
from nrp_core.scene.reading.context import Element, Notes

_SHAPES: Final = "box cylinder sphere mesh capsule plane"
_TOUCH: Final = (
    "lateral_friction rolling_friction spinning_friction stiffness damping contact_cfm contact_erp "
    "inertia_scaling restitution friction_anchor"
)
_TABLE: Final = {
    "robot": ("name version", ""),  # its children are checked where they are converted
    "gazebo": ("reference", ""),  # and those of this one in SDF
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
    "plane": ("normal", ""),
    "mesh": ("filename scale", ""),
    "material": ("name", "color texture"),
    "color": ("rgba", ""),
    "texture": ("filename", ""),
    "contact": ("", _TOUCH),  # for PyBullet
    **{f"contact/{name}": ("value", "") for name in _TOUCH.split()},
    "joint": ("name type", "origin parent child axis calibration dynamics limit mimic safety_controller"),
    "parent": ("link", ""),
    "child": ("link", ""),
    "axis": ("xyz", ""),
    "dynamics": ("damping friction", ""),
    "limit": ("lower upper effort velocity acceleration deceleration jerk", ""),
    "mimic": ("joint multiplier offset", ""),
    "safety_controller": ("soft_lower_limit soft_upper_limit k_position k_velocity", ""),
    "transmission": ("name type", "type joint actuator mechanicalReduction"),
    "transmission/type": ("", ""),
    "transmission/joint": ("name", "hardwareInterface role offset mechanicalReduction"),
    "transmission/actuator": ("name", "hardwareInterface role offset mechanicalReduction"),
    "ros2_control": ("name type", "hardware joint sensor gpio transmission"),
    "ros2_control/hardware": ("", "plugin param group"),
    "ros2_control/joint": ("name", "command_interface state_interface param"),
    "command_interface": ("name", "param"),
    "state_interface": ("name", "param"),
    "param": ("name", ""),
}
"""Attributes and children by element, or by the element around it and the element."""
_KNOWN: Final = {
    tag: (frozenset(attributes.split()), frozenset(children.split()))
    for tag, (attributes, children) in _TABLE.items()
}
_ELSEWHERE: Final = {name: tag for tag in ("origin", "dynamics", "limit") for name in _TABLE[tag][0].split()}
"""Attributes that only one element has."""
_OF_ROBOT: Final = ("link", "joint", "gazebo", "transmission", "ros2_control")
_FREE: Final = ("robot", "gazebo")
"""Elements whose children are checked elsewhere."""
_WITH_TEXT: Final = ("gazebo", "transmission/type", "param")
_SINGLE: Final = ("inertia", "mass", "cylinder", "dynamics", "limit", "safety_controller")
_NUMBERS: Final = {
    **dict.fromkeys(("xyz", "rpy", "size", "normal"), 3),
    **{name: 1 for tag in _SINGLE for name in _TABLE[tag][0].split()},
    **dict.fromkeys(("multiplier", "offset"), 1),
    "quat_xyzw": 4,
}
"""The numbers that an attribute holds, by its name."""
_PARAMETERS: Final = ("mimic", "multiplier", "initial_value", "min", "max")
"""The names of parameters of joints and their interfaces that ros2_control itself has."""
_HARMLESS: Final = {("collision", "material")}
"""What exporters write in vain: a collision is not seen."""
_ZEROS: Final = re.compile(r"[-+0.\s]*")
"""The numbers of ``<origin>`` in another element that say nothing, as exporters write them for axes."""
_FORMER: Final = "joint_properties"
"""What had the attributes of <dynamics> once."""
_ALIKE: Final = 0.6
_OF_ROS: Final = ("transmission", "ros2_control", "command_interface", "state_interface", "param")
_CLOSE: Final = 0.8
"""The same where files have elements of many controllers."""


def check_vocabulary(element: Element, notes: Notes, around: str = "") -> None:
    """Warn of misspelt attributes and elements of a robot, which would silently have no effect.

    Args:
        element: the element.
        notes: receives the warnings.
        around: the tag of the element around it.
    """
    entry = _entry(element.tag, around)
    if entry is None:
        return
    attributes, children = _KNOWN[entry]
    for problem, subject in (*_attributes(element, entry), *_values(element, attributes)):
        notes.warn(element, Code.NRP383, problem, subject=subject)
    text = element.text.strip()
    if text and entry not in _WITH_TEXT:
        written = f'; write {next(iter(_TABLE[entry][0].split()))}="{text}"' if attributes else ""
        message = (
            f"the text '{text:.30}' in <{element.tag}> is ignored: URDF has values in attributes{written}"
        )
        notes.warn(element, Code.NRP383, message, subject=element.tag)
    for child in element.children:
        if element.tag not in _FREE and child.tag not in children and ":" not in child.tag:
            _check_misplaced(child, element, children, notes)
        elif element.tag != "gazebo":
            check_vocabulary(child, notes, element.tag)


def _entry(tag: str, around: str) -> str | None:
    """Return the entry of an element; None for one that is not of URDF."""
    return next((entry for entry in (f"{around}/{tag}", tag) if entry in _KNOWN), None)


def _attributes(element: Element, entry: str) -> Iterator[tuple[str, str]]:
    """Yield the attributes that an element does not have, with a message."""
    attributes, children = _KNOWN[entry]
    for name in sorted(element.attributes.keys() - attributes):
        if ":" in name or not attributes:
            continue
        alone = not children and not attributes & element.attributes.keys()
        message = f"<{element.tag}> has no attribute '{name}': ignored"
        if _ELSEWHERE.get(name) == "origin" and _ZEROS.fullmatch(element.attributes[name]):
            continue
        if name in _ELSEWHERE:
            yield f"{message}; it belongs in <{_ELSEWHERE[name]}>", name
        elif alone or _resembles(name, attributes - element.attributes.keys()):
            yield f"{message}{did_you_mean(name, attributes)}", name


def _values(element: Element, attributes: frozenset[str]) -> Iterator[tuple[str, str]]:
    """Yield the attributes with invalid numbers; the readers refuse the ones that they use."""
    for name in sorted(element.attributes.keys() & attributes & _NUMBERS.keys()):
        text, count = element.attributes[name], _NUMBERS[name]
        try:
            element.parse_numbers(text, count, finite=False)
        except SceneError:
            wanted = "a number" if count == 1 else f"{count} numbers"
            yield f"{name} of <{element.tag}> must hold {wanted}, not '{text}': ignored", name
    if "rgba" in attributes and not _is_colour(text := element.attributes.get("rgba", "0 0 0")):
        yield f"rgba of <{element.tag}> must hold 4 numbers, not '{text}': ignored", "rgba"
    if element.tag == "param" and (hint := hint_if_close(element.attributes.get("name", ""), _PARAMETERS)):
        name = element.attributes["name"]
        if name not in _PARAMETERS:
            yield f"<param> '{name}' is ignored{hint}", name


def _is_colour(text: str) -> bool:
    """Return whether a text begins with three numbers; a fifth one is reported where it is read."""
    try:
        return len([float(word) for word in text.split()]) >= 3
    except ValueError:
        return False


def _check_misplaced(child: Element, parent: Element, valid: frozenset[str], notes: Notes) -> None:
    """Warn of an element that its parent does not have: a misspelt one, or one of another element."""
    of_ros = parent.tag in _OF_ROS
    holders = [
        f"<{tag.rpartition('/')[2]}>"
        for tag, (_, inner) in _KNOWN.items()
        if child.tag in inner and (of_ros or not tag.startswith(_OF_ROS))
    ]
    holders = ["<robot>"] if child.tag in _OF_ROBOT else list(dict.fromkeys(holders))
    if holders and (parent.tag, child.tag) not in _HARMLESS:
        hint = f"; it belongs in {' or '.join(holders)}"
    elif not holders and _resembles(child.tag, valid, _CLOSE if of_ros else _ALIKE):
        hint = did_you_mean(child.tag, valid)
    elif child.tag == _FORMER and parent.find("dynamics") is None and _slows(child):
        hint = "; it is <dynamics> now"
    else:
        return
    message = f"URDF has no <{child.tag}> in a <{parent.tag}>: ignored{hint}"
    notes.warn(child, Code.NRP383, message, subject=child.tag)


def _slows(former: Element) -> bool:
    return any(former.attributes.get(name, "").strip("0.") for name in _KNOWN["dynamics"][0])


def _resembles(name: str, known: frozenset[str], cutoff: float = _ALIKE) -> bool:
    return bool(get_close_matches(name, known, n=1, cutoff=cutoff))
