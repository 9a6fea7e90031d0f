"""The ``<gazebo>`` blocks of URDF: elements of SDF for properties that URDF lacks."""

from __future__ import annotations

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.parameters import warn_of_parameters
from nrp_core.world.scene.reading.plugins import ROS_CONTROL, plugin_name
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.urdf.elements import new

# for Gazebo's solver, or for its conversion to SDF
_SOLVER = {
    *(
        "kp",
        "kd",
        "minDepth",
        "maxVel",
        "maxContacts",
        "fdir1",
        "laserRetro",
        "provideFeedback",
    ),
    *("implicitSpringDamper", "cfmDamping", "stopCfm", "stopErp", "fudgeFactor"),
    *("disableFixedJointLumping", "preserveFixedJoint"),
}
_BEFORE_SDF = ("sensor", "controller", "body", "geom", "interface")
"""Namespaces of elements of the first Gazebo; SDF has elements of some of these names without one."""
_OF_CONTROL = (
    *(("ros", name) for name in ("namespace", "remapping")),
    *((name,) for name in ("robotNamespace", "robotParam", "robotSimType", "legacyModeNS", "controlPeriod")),
)
"""Parameters of plugins that run controllers."""
_NAMES = {"selfCollide": "self_collide"}
"""The names that elements have in SDF, if not the same."""
_VALUES = {*_SOLVER, "material", "mu1", "mu2", "selfCollide", "turnGravityOff", "dampingFactor"}
"""Elements that hold a value only."""
_SPRINGS = {"springStiffness": "spring_stiffness", "springReference": "spring_reference"}


def apply_block(block: Element, model: Element, notes: Notes) -> None:
    """Move the contents of a ``<gazebo>`` block to their places in SDF."""
    name = block.attributes.get("reference")
    target = model
    if name == WORLD:
        return  # it keeps the world as a link in Gazebo's own conversion
    if name is not None:
        named = {part.attributes["name"]: part for part in model.all("link", "joint")}
        if name not in named:
            hint = did_you_mean(name, named)
            notes.warn(
                block, Code.NRP263, f"ignored: the robot has no link or joint '{name}'{hint}", subject=name
            )
            return
        target = named[name]
    for child in block.children:
        if child.tag.rpartition(":")[0] in _BEFORE_SDF:
            message = f"<{child.tag}> is of Gazebo before its version 1.0 and SDF: ignored"
            notes.warn(child, Code.NRP263, message, subject=child.tag)
            continue
        if child.tag in _VALUES:
            for inner in child.children:
                message = f"<{inner.tag}> in <{child.tag}>, which holds a value, is ignored"
                notes.warn(inner, Code.NRP263, message, subject=inner.tag)
        if child.tag not in _SOLVER and not _controls_nothing(child, notes):
            _give(child, target)


def _controls_nothing(element: Element, notes: Notes) -> bool:
    """Return whether an element is a plugin that runs controllers and names no file with them."""
    if element.tag != "plugin" or plugin_name(element) not in ROS_CONTROL or element.word("parameters"):
        return False
    for tags in _OF_CONTROL:
        element.find(*tags)
    warn_of_parameters(element, notes)
    return True


def _give(child: Element, target: Element) -> None:
    if child.tag == "material":
        script = new("script", child, new("name", child, text=_value(child)))
        for visual in target.all("visual"):
            visual.children.insert(0, new("material", child, script))
    elif child.tag in ("mu1", "mu2"):
        for collision in target.all("collision"):
            friction = _within(collision, child, "surface", "friction", "ode")
            friction.children.append(new(child.tag.replace("mu1", "mu"), child, text=_value(child)))
    elif child.tag in _SPRINGS:
        dynamics = _within(target, child, "axis", "dynamics")
        dynamics.children.append(new(_SPRINGS[child.tag], child, text=_value(child)))
    elif child.tag == "turnGravityOff":
        target.children.append(new("gravity", child, text="0" if _value(child) in ("1", "true") else "1"))
    elif child.tag == "dampingFactor":
        slower = (new(tag, child, text=_value(child)) for tag in ("linear", "angular"))
        target.children.append(new("velocity_decay", child, *slower))
    elif child.tag in ("visual", "collision"):
        for part in target.all(child.tag):
            part.children[:0] = child.children
    else:
        name = _NAMES.get(child.tag)
        target.children.append(new(name, child, text=_value(child)) if name else child)


def _within(element: Element, at: Element, *tags: str) -> Element:
    """Return the descendant along a path of tags, created if it is missing."""
    here = element
    for tag in tags:
        found = here.find(tag)
        if found is None:
            found = new(tag, at)
            here.children.append(found)
        here = found
    return here


def _value(element: Element) -> str:
    return element.text or element.attributes.get("value", "")
