"""Images as in worlds of the platform: read-only arrays by row, column and channel."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nrp_core.world.messages.cv_bridge import CvBridge, CvBridgeError
from nrp_core.world.messages.sensor_msgs import Image

_BRIDGE = CvBridge()


def shaped(message: Any) -> Any:
    """Return an image of ROS as a shaped array without padding of rows; other messages unchanged.

    An image in an unknown encoding or with a wrong size stays unchanged, too.
    """
    if not isinstance(message, Image):
        return message
    try:
        image = _BRIDGE.imgmsg_to_cv2(message)
    except (CvBridgeError, ValueError):
        return message
    image.flags.writeable = False
    return replace(message, data=image, step=image.strides[0])
