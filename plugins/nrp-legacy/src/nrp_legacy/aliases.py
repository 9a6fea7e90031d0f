"""Find topics by the names of other versions of the platform.

Until 2018 a robot's topics had no prefix (``/husky/camera``), later its id was the prefix
(``/husky/husky/camera``); the id of a robot without one was ``robot``.
"""

from __future__ import annotations

from typing import Any

from nrp_core.world.messages.base import type_name
from nrp_core.world.world import World

_JOINTS = "/joints"
"""The end of the name of the iCub's topic for joint states."""


def find_alias(name: str, kind: Any, world: World) -> str | None:
    """Return the one topic that exists under another prefix than this name, if there is one.

    Args:
        name: the name in a transfer function.
        kind: the message type in the transfer function, None for any.
        world: the world, before further topics are declared.
    """
    if name in world.topics:
        return None
    served = [
        topic.name
        for topic in world.topics.values()
        if _differ_by_prefix(name, topic.name) and (kind is None or type_name(kind) == type_name(topic.type))
    ]
    if not served and name.endswith(_JOINTS):
        return find_alias(name.removesuffix(_JOINTS) + "/joint_states", kind, world) or _states(name, world)
    return served[0] if len(served) == 1 else None


def _states(name: str, world: World) -> str | None:
    states = name.removesuffix(_JOINTS) + "/joint_states"
    return states if states in world.topics else None


def _differ_by_prefix(name: str, served: str) -> bool:
    """Whether two names agree once the first part of one of them, or of both, is left out."""
    name_rest, served_rest = _without_prefix(name), _without_prefix(served)
    if not served_rest:
        return False
    return served_rest in (name, name_rest) or bool(name_rest and name_rest == served)


def _without_prefix(name: str) -> str:
    """Return a name without its first part, empty where nothing is left."""
    rest = name.removeprefix("/").partition("/")[2]
    return f"/{rest}" if rest else ""
