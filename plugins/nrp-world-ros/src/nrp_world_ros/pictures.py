"""Pictures as worlds of the platform have them: arrays by row, column and channel, nobody's to change."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nrp_core.world.messages.cv_bridge import CvBridge, CvBridgeError
from nrp_core.world.messages.sensor_msgs import Image

_BRIDGE = CvBridge()


def shaped(message: Any) -> Any:
    """Return a picture of ROS with its shape, without what fills up its rows; any other message as it is.

    A picture in an encoding that is not known, or that is not as large as it says, stays as it came, too.
    """
    if not isinstance(message, Image):
        return message
    try:
        picture = _BRIDGE.imgmsg_to_cv2(message)
    except (CvBridgeError, ValueError):
        return message
    picture.flags.writeable = False
    return replace(message, data=picture, step=picture.strides[0])
