"""``<contact>`` of a URDF link as in PyBullet's reader: stiffness, rolling friction and restitution.

In SDF it is ``<pybullet:contact link="wheel">`` in the model, with the same elements.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Findings
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.origin import Native
from nrp_world_pybullet.library import bullet

_ANCHOR = "friction_anchor"
"""An element without a value."""
_ARGUMENTS = {
    "lateral_friction": "lateralFriction",
    "rolling_friction": "rollingFriction",
    "spinning_friction": "spinningFriction",
    "restitution": "restitution",
    "stiffness": "contactStiffness",
    "damping": "contactDamping",
}
_UNUSED = ("contact_cfm", "contact_erp", "inertia_scaling")
"""Elements of PyBullet's reader that cannot be set in a world that was not read by it."""


def set_contacts(model: Model, links: Mapping[str, tuple[int, int]], client: int, warnings: Findings) -> None:
    """Set the properties of contacts that a model has for PyBullet.

    Args:
        model: the model.
        links: the multi-body and index of each link.
        client: the physics client.
        warnings: receives the elements that are valid and not used.

    Raises:
        SceneError: an element is invalid; the message names its file and line.
    """
    for element in model.native:
        if element.namespace == "pybullet":
            if element.tag != "contact":
                hint = did_you_mean(element.tag, ("contact",))
                raise element.error(f"not an element that is used here{hint}; valid: contact")
            link = element.attribute("link")
            if link is None or link not in links:
                wanted = 'it needs link="..."' if link is None else f"the model has no link '{link}'"
                raise element.error(f"{wanted}{did_you_mean(link or '', links)}")
            for each in (each for each in element.children if each.tag in _UNUSED):
                message = f"<{each.tag}> of the <contact> of '{link}' is not used"
                warnings.add(Code.NRP263, message, subject=each.tag, path=each.path, line=each.line or None)
            used = [each for each in element.children if each.tag not in (*_UNUSED, _ANCHOR)]
            values = dict(map(_value, used))
            if any(each.tag == _ANCHOR for each in element.children):
                bullet.changeDynamics(*links[link], frictionAnchor=1, physicsClientId=client)
            if ("contactStiffness" in values) != ("contactDamping" in values):
                raise element.error("stiffness and damping only act together; give both")
            bullet.changeDynamics(*links[link], **values, physicsClientId=client)


def _value(element: Native) -> tuple[str, float]:
    """Return PyBullet's argument and the value for an element such as ``<stiffness value="1000"/>``."""
    if element.tag not in _ARGUMENTS:
        hint = did_you_mean(element.tag, _ARGUMENTS)
        raise element.error(f"not a property that can be set{hint}; valid: {', '.join(_ARGUMENTS)}")
    text = element.attribute("value") or ""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not (isfinite(value) and value >= 0):
        raise element.error(f"its value must be a number of 0 or more, not '{text}'")
    return _ARGUMENTS[element.tag], value
