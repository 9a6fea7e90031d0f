"""Attributes of MJCF by the schema of the installed MuJoCo, so that those of a newer one pass through too."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache
from typing import Any

import numpy as np

from nrp_world_mujoco.library import mujoco

_FIELDS = {
    "actuatorfrclimited": "actfrclimited",
    "actuatorfrcrange": "actfrcrange",
    "actuatorgravcomp": "actgravcomp",
    "solimpfriction": "solimp_friction",
    "solimplimit": "solimp_limit",
    "solreffriction": "solref_friction",
    "solreflimit": "solref_limit",
}
"""Fields of a specification that are not named as the attribute."""


@cache
def attributes_of(element: str) -> tuple[str, ...]:
    """Return the attributes that an element of a ``<default>`` may have: all but its name and its ends."""
    found: list[str] = []
    default = reading = False
    for line in mujoco.mj_printSchema(False, True).splitlines():
        words = line.split()
        if len(words) > 1 and words[1].startswith("("):
            depth = len(line) - len(line.lstrip())
            default = words[0] == "default" if depth <= 3 else default
            reading, words = default and depth > 3 and words[0] == element, words[2:]
        if reading:
            found.extend(words)
    return tuple(found)


def field_of(attribute: str) -> str:
    """Return the field of a specification that an attribute sets."""
    return _FIELDS.get(attribute, attribute)


def stated(part: Any, usual: Any, element: str, without: Collection[str]) -> dict[str, str]:
    """Return the attributes with which a part of a specification differs from another one.

    Args:
        part: the part, for which the defaults and classes of the file are resolved.
        usual: a part of the same kind as MuJoCo creates it.
        element: its element in a ``<default>``.
        without: attributes that are not wanted.
    """
    names = [name for name in attributes_of(element) if name not in without]
    values = {name: (getattr(part, field_of(name)), getattr(usual, field_of(name))) for name in names}
    return {name: _text(given, name) for name, (given, default) in values.items() if np.any(given != default)}


_WORDS = {
    "interp": ("zoh", "linear", "cubic"),
    "actuatorgravcomp": ("false", "true"),
    "actearly": ("false", "true"),
}
"""Words for the numbers of fields."""


def _text(value: Any, name: str) -> str:
    if name in _WORDS:
        return _WORDS[name][int(value)]
    if hasattr(value, "name"):  # of an enumeration
        return str(value.name).rpartition("_")[2].lower()
    return " ".join(f"{float(number):.17g}" for number in np.ravel(value))
