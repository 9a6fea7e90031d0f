"""The installed brain backends: the entry points in ``nrp_core.brain``."""

from __future__ import annotations

from nrp_core.brain.backend import BRAIN_INTERFACE_VERSION, BrainBackend
from nrp_core.registry import Registry

BRAIN_GROUP = "nrp_core.brain"


def brains() -> Registry[BrainBackend]:
    """Return the registry of brain backends."""
    return Registry(BRAIN_GROUP, "brain backend", [BrainBackend], BRAIN_INTERFACE_VERSION)
