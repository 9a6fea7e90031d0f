"""Load rospy, or report how to install it; it is not in a package index."""

from __future__ import annotations

import sysconfig
from types import ModuleType

from nrp_core.errors import BackendLoadError

INSTALL = (
    "apt-get install --no-install-recommends python3-rospy python3-roslaunch && "
    f"echo /usr/lib/python3/dist-packages > {sysconfig.get_path('purelib')}/ros.pth"
)
"""Path file for Debian's rospy in this Python; added paths come after installed packages."""


def load_rospy() -> ModuleType:
    """Return rospy.

    Raises:
        BackendLoadError: it or one of its requirements is missing.
    """
    try:
        import rosgraph  # noqa: F401  a part of ROS that rospy is useless without
        import rospy
    except ImportError as error:
        raise BackendLoadError(f"ROS 1 is not in this Python ({error})", remedy=INSTALL) from error
    module: ModuleType = rospy
    return module
