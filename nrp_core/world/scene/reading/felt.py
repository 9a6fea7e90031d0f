"""The collisions that contact sensors name: those of their link, or of one that is fixed to it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from nrp_core.world.scene.checks import rigid_groups
from nrp_core.world.scene.model import Joint, Link
from nrp_core.world.scene.sensing import MountedSensor

_LUMP: Final = "_fixed_joint_lump__"
"""What Gazebo Classic writes into the name of a collision of a link that is fixed to another one."""
_ADDED: Final = re.compile(r"(_collision)?(_\d+)?$")
"""What it adds at the end of such a name."""


def with_felt_collisions(links: Sequence[Link], joints: Sequence[Joint]) -> tuple[Link, ...]:
    """Return links whose contact sensors name collisions as they are here.

    A sensor has them in a field ``collisions``. One of another link is ``link::collision``, and the name of
    one that does not exist stays as it is.
    """
    fixed = [(joint.parent, joint.child) for joint in joints if joint.kind == "fixed"]
    groups = rigid_groups({each for ends in fixed for each in ends} | {link.name for link in links}, fixed)
    owned = {link.name: [each.name for each in link.collisions] for link in links}

    def felt(sensor: MountedSensor, link: str) -> MountedSensor:
        names: Sequence[str] = getattr(sensor, "collisions", ())
        kept: dict[str, Any] = {
            "collisions": tuple(_found(name, link, groups[link], owned) or name for name in names)
        }
        return replace(sensor, **kept) if names and kept["collisions"] != names else sensor

    return tuple(
        replace(link, sensors=tuple(felt(each, link.name) for each in link.sensors)) for link in links
    )


def _found(name: str, link: str, fixed: set[str], owned: Mapping[str, Sequence[str]]) -> str:
    """Return the name of a collision from the link of its sensor; empty if there is none."""
    if name in owned[link]:
        return name
    for candidate in _candidates(name):
        for owner in (link, *sorted(fixed - {link})):
            if candidate in owned.get(owner, ()):
                return candidate if owner == link else f"{owner}::{candidate}"
    return ""


def _candidates(name: str) -> Iterator[str]:
    """Yield the names in a file that may stand behind one of Gazebo Classic."""
    inner = name.rpartition(_LUMP)[2]
    yield inner
    yield re.sub(r"_\d+$", "", inner)
    yield _ADDED.sub("", inner)
