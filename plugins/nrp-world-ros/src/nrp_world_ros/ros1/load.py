"""Load rospy, or say how to get it; no package index has it."""

from __future__ import annotations

import sysconfig
from types import ModuleType

from nrp_core.errors import BackendLoadError

INSTALL = (
    "apt-get install --no-install-recommends python3-rospy python3-roslaunch && "
    f"echo /usr/lib/python3/dist-packages > {sysconfig.get_path('purelib')}/ros.pth"
)
"""What makes Debian's rospy known to this Python; a path added so comes after what is installed there."""


def load_rospy() -> ModuleType:
    """Return rospy.

    Raises:
        BackendLoadError: it is not there, or something that it needs is not.
    """
    try:
        import rosgraph  # noqa: F401  a part of ROS that rospy is useless without
        import rospy
    except ImportError as error:
        raise BackendLoadError(f"ROS 1 is not in this Python ({error}); try: {INSTALL}") from error
    module: ModuleType = rospy
    return module
