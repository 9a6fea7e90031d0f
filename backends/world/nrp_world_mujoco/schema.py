"""Attributes of MJCF by the schema of the installed MuJoCo, so that those of a newer one pass through too."""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import cache
from typing import Any

import numpy as np

from nrp_world_mujoco.library import mujoco

_FIELDS = {
    "actuatorgroupdisable": "disableactuator",
    "actuatorfrclimited": "actfrclimited",
    "actuatorfrcrange": "actfrcrange",
    "actuatorgravcomp": "actgravcomp",
    "fluidcoef": "fluid_coefs",
    "fluidshape": "fluid_ellipsoid",
    "hfield": "hfieldname",
    "mesh": "meshname",
    "shellinertia": "typeinertia",
    "solimpfriction": "solimp_friction",
    "solimplimit": "solimp_limit",
    "solreffriction": "solref_friction",
    "solreflimit": "solref_limit",
    "user": "userdata",
}
"""Fields of a specification that are not named as the attribute."""
_WITHOUT_FIELD = ("axisangle", "euler", "input", "xyaxes", "zaxis")
"""Attributes that are converted where they are read."""


@cache
def attributes_of(element: str) -> tuple[str, ...]:
    """Return the attributes that an element of a ``<default>`` may have: all but its name and its ends.

    Or those of a section of a file, such as ``option``.
    """
    found: list[str] = []
    default = reading = False
    for line in mujoco.mj_printSchema(False, True).splitlines():
        words = line.split()
        if len(words) > 1 and words[1].startswith("("):
            depth = len(line) - len(line.lstrip())
            default = words[0] == "default" if depth <= 3 else default
            reading, words = (default or depth <= 3) and words[0] == element, words[2:]
        if reading:
            found.extend(words)
    return tuple(found)


def field_of(part: Any, attribute: str) -> str:
    """Return the field of a part of a specification that an attribute sets."""
    return attribute if hasattr(part, attribute) else _FIELDS.get(attribute, attribute)


def stated(part: Any, usual: Any, element: str, without: Collection[str]) -> dict[str, str]:
    """Return the attributes with which a part of a specification differs from another one.

    Args:
        part: the part, for which the defaults and classes of the file are resolved.
        usual: a part of the same kind as MuJoCo creates it.
        element: its element in a ``<default>``.
        without: attributes to omit.
    """
    names = [
        name for name in attributes_of(element) if name not in without and hasattr(part, field_of(part, name))
    ]
    fields = {name: field_of(part, name) for name in names}
    values = {name: (getattr(part, field), getattr(usual, field)) for name, field in fields.items()}
    return {
        name: text_of(given, name) for name, (given, default) in values.items() if np.any(given != default)
    }


def without_field(spec: Any) -> list[str]:
    """Return the attributes in a file that the installed MuJoCo knows, but its specifications do not have."""
    unknown = _unknown()
    text = spec.to_xml() if unknown else ""
    return [
        f"the attribute {name} of <{element}>"
        for element, name in unknown
        if re.search(rf"<{element}\b[^>]*\s{name}=", text)
    ]


@cache
def _unknown() -> list[tuple[str, str]]:
    fresh = mujoco.MjSpec()
    parts = {
        "option": fresh.option,
        "joint": fresh.worldbody.add_joint(),
        "geom": fresh.worldbody.add_geom(),
        "tendon": fresh.add_tendon(),
        "general": fresh.add_actuator(),
        "pair": fresh.add_pair(),
        "equality": fresh.add_equality(),
    }
    return [
        (element, name)
        for element, part in parts.items()
        for name in attributes_of(element)
        if name not in _WITHOUT_FIELD and not hasattr(part, field_of(part, name))
    ]


_WORDS = {
    "cone": ("pyramidal", "elliptic"),
    "integrator": ("Euler", "RK4", "implicit", "implicitfast"),
    "solver": ("PGS", "CG", "Newton"),
    "jacobian": ("dense", "sparse", "auto"),
    "fluidshape": ("none", "ellipsoid"),
    "interp": ("zoh", "linear", "cubic"),
    "actuatorgravcomp": ("false", "true"),
    "actearly": ("false", "true"),
}
"""Words for the numbers of fields."""


def text_of(value: Any, name: str) -> str:
    """Return the value of an attribute as files have it."""
    if name in _WORDS:
        return _WORDS[name][int(value)]
    if hasattr(value, "name"):  # of an enumeration
        return str(value.name).rpartition("_")[2].lower()
    return " ".join(f"{float(number):.17g}" for number in np.ravel(value))
