"""Elements that a robot or room file may contain once, and that it contains twice with different contents."""

from __future__ import annotations

from typing import Final

from nrp_core.findings import Code
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element

_ONCE: Final = {
    "link": "inertial pose gravity self_collide",
    "inertial": "mass inertia pose origin density",
    "inertia": "ixx iyy izz",
    "joint": "parent child axis axis2 origin limit dynamics mimic safety_controller pose",
    "axis": "xyz limit dynamics initial_position",
    "axis2": "xyz limit dynamics initial_position",
    "limit": "lower upper effort velocity",
    "dynamics": "damping friction spring_reference spring_stiffness",
    "visual": "pose origin geometry material",
    "collision": "pose origin geometry surface",
    "model": "pose static",
    "box": "size",
    "sphere": "radius",
    "cylinder": "radius length",
    "material": "ambient diffuse specular emissive color",
    "ode": "mu mu2",
    "sensor": "update_rate topic pose ray lidar imu contact",
    "camera": "horizontal_fov image clip",
    "image": "width height",
    "clip": "near far",
    "ray": "scan range noise",
    "lidar": "scan range noise",
    "scan": "horizontal vertical",
    "range": "min max",
    "horizontal": "samples min_angle max_angle",
    "noise": "type mean stddev",
    "world": "gravity",
    "gazebo": "mu1 mu2 turnGravityOff dampingFactor selfCollide springStiffness springReference",
}
"""The elements of SDF and URDF that occur once in an element, by that element."""
_BY_PARENT: Final = {parent: frozenset(children.split()) for parent, children in _ONCE.items()}


def check_repeated(element: Element, notes: Notes) -> None:
    """Warn of elements that contradict an earlier one in the same element: only the first is read."""
    first: dict[str, Element] = {}
    once = _BY_PARENT.get(element.tag, frozenset())
    for child in element.children:
        check_repeated(child, notes)
        if child.tag not in once:
            continue
        earlier = first.setdefault(child.tag, child)
        if earlier is not child and _contents(earlier) != _contents(child):
            name = element.attributes.get("name")
            owner = f"<{element.tag}>" + (f" '{name}'" if name else "")
            message = (
                f"a second <{child.tag}> in the {owner} is ignored: the one of line {earlier.line} is used"
            )
            notes.warn(child, Code.NRP263, message, subject=f"{owner}/{child.tag}")


def _contents(element: Element) -> object:
    return element.text, element.attributes, [(one.tag, _contents(one)) for one in element.children]
