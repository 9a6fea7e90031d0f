"""The installed world backends: the entry points in ``nrp_core.world``."""

from __future__ import annotations

from nrp_core.registry import Registry
from nrp_core.world.backend import WORLD_INTERFACE_VERSION, WorldBackend

WORLD_GROUP = "nrp_core.world"


def worlds() -> Registry[WorldBackend]:
    """Return the registry of world backends."""
    return Registry(WORLD_GROUP, "world backend", [WorldBackend], WORLD_INTERFACE_VERSION)
