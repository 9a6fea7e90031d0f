"""Load Cyclone DDS, or report how to install it."""

from __future__ import annotations

from types import ModuleType

from nrp_core.errors import BackendLoadError

INSTALL = "pip install 'nrp-world-ros[ros2]'"


def load_dds() -> ModuleType:
    """Return Cyclone DDS.

    Raises:
        BackendLoadError: it is not installed.
    """
    try:
        import cyclonedds.domain
    except ImportError as error:
        raise BackendLoadError(f"ROS 2 is not in this Python ({error})", remedy=INSTALL) from error
    module: ModuleType = cyclonedds
    return module
