"""``cv_bridge``: pictures as messages and as arrays."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.world.messages.sensor_msgs import Image
from nrp_legacy.shims.modules import module

_CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4}
_PASS = "passthrough"


class CvBridgeError(TypeError):
    """An encoding that is not known."""


class CvBridge:
    """Converts between messages and arrays of shape ``(height, width)`` or ``(height, width, channels)``."""

    def imgmsg_to_cv2(self, img_msg: Image, desired_encoding: str = _PASS) -> npt.NDArray[np.uint8]:
        """Return a picture as an array of its own.

        Raises:
            CvBridgeError: an encoding is not known.
        """
        channels = _channels(img_msg.encoding)
        flat = np.frombuffer(np.ascontiguousarray(img_msg.data).tobytes(), np.uint8)
        picture = flat.reshape(img_msg.height, img_msg.width, channels)
        wanted = img_msg.encoding if desired_encoding == _PASS else desired_encoding
        return _converted(picture, img_msg.encoding, wanted)

    def cv2_to_imgmsg(self, cvim: npt.NDArray[np.uint8], encoding: str = _PASS) -> Image:
        """Return an array as a message; where no encoding is given, OpenCV's own order of channels is meant.

        Raises:
            CvBridgeError: an encoding is not known.
        """
        picture = np.ascontiguousarray(cvim, np.uint8)
        height, width = picture.shape[:2]
        channels = 1 if picture.ndim == 2 else picture.shape[2]
        name = encoding if encoding != _PASS else {1: "mono8", 3: "bgr8", 4: "bgra8"}[channels]
        _channels(name)
        return Image(height=height, width=width, encoding=name, step=width * channels, data=picture)


def _channels(encoding: str) -> int:
    if encoding not in _CHANNELS:
        raise CvBridgeError(f"no encoding '{encoding}'; valid: {', '.join(_CHANNELS)}")
    return _CHANNELS[encoding]


def _converted(picture: npt.NDArray[np.uint8], given: str, wanted: str) -> npt.NDArray[np.uint8]:
    import cv2

    _channels(wanted)
    if {given[:3], wanted[:3]} == {"rgb", "bgr"}:
        picture = picture[..., [2, 1, 0]]
    elif wanted in ("mono8", "8UC1") and picture.shape[2] >= 3:
        code = cv2.COLOR_RGB2GRAY if given[:3] == "rgb" else cv2.COLOR_BGR2GRAY
        return np.asarray(cv2.cvtColor(np.ascontiguousarray(picture[..., :3]), code), np.uint8)
    elif picture.shape[2] == 1 and _CHANNELS[wanted] == 3:
        picture = picture.repeat(3, axis=2)
    copied = np.array(picture)
    return copied[..., 0] if copied.shape[2] == 1 else copied


def cv_bridge_module() -> ModuleType:
    """Return the module."""
    bridge: dict[str, Any] = {"CvBridge": CvBridge, "CvBridgeError": CvBridgeError}
    return module("cv_bridge", **bridge)
