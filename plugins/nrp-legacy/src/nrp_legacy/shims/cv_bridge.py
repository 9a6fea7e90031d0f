"""``cv_bridge``: images as messages and as arrays."""

from __future__ import annotations

from types import ModuleType

from nrp_core.world.messages.cv_bridge import CvBridge as CvBridge
from nrp_core.world.messages.cv_bridge import CvBridgeError
from nrp_legacy.shims.modules import module


def cv_bridge_module() -> ModuleType:
    """Return the module."""
    return module("cv_bridge", CvBridge=CvBridge, CvBridgeError=CvBridgeError)
