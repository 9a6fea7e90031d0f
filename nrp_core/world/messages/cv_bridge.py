"""``CvBridge``, by the name that users of ROS know: pictures as messages and as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.world.messages.sensor_msgs import CompressedImage, Image

Picture = npt.NDArray[Any]

_CHANNELS = {
    "mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4, "8UC4": 4,
    "mono16": 1, "16UC1": 1, "16UC3": 3, "32FC1": 1, "32FC3": 3, "64FC1": 1,
}  # fmt: skip
_TYPES = {"16": "uint16", "32": "float32", "64": "float64"}
_PASS = "passthrough"


class CvBridgeError(TypeError):
    """An encoding that is not known."""


class CvBridge:
    """Converts between messages and arrays of shape ``(height, width)`` or ``(height, width, channels)``."""

    def imgmsg_to_cv2(self, img_msg: Image, desired_encoding: str = _PASS) -> Picture:
        """Return a picture as an array of its own.

        Raises:
            CvBridgeError: an encoding is not known, or there is no way from one to the other.
        """
        channels, dtype = _format(img_msg.encoding)
        flat = np.frombuffer(np.ascontiguousarray(img_msg.data).tobytes(), dtype)
        picture = flat.reshape(img_msg.height, -1)[:, : img_msg.width * channels]
        picture = picture.reshape(img_msg.height, img_msg.width, channels)
        wanted = img_msg.encoding if desired_encoding == _PASS else desired_encoding
        return _converted(picture, img_msg.encoding, wanted)

    def cv2_to_imgmsg(self, cvim: Picture, encoding: str = _PASS) -> Image:
        """Return an array as a message; where no encoding is given, OpenCV's own order of channels is meant.

        Raises:
            CvBridgeError: the encoding is not known.
        """
        given = np.ascontiguousarray(cvim)
        height, width = given.shape[:2]
        channels = 1 if given.ndim == 2 else given.shape[2]
        name = encoding if encoding != _PASS else _own_name(given.dtype, channels)
        _, dtype = _format(name)
        picture = given.astype(dtype, copy=False)
        return Image(
            height=height, width=width, encoding=name, step=width * channels * picture.itemsize, data=picture
        )

    def compressed_imgmsg_to_cv2(
        self, cmprs_img_msg: CompressedImage, desired_encoding: str = "bgr8"
    ) -> Picture:
        """Return the picture in the bytes of a file as an array."""
        import cv2

        found = cv2.imdecode(np.frombuffer(bytes(cmprs_img_msg.data), np.uint8), cv2.IMREAD_COLOR)
        if found is None:
            raise CvBridgeError(f"these bytes are not an image of the format '{cmprs_img_msg.format}'")
        return _converted(
            np.asarray(found), "bgr8", "bgr8" if desired_encoding == _PASS else desired_encoding
        )

    def cv2_to_compressed_imgmsg(self, cvim: Picture, dst_format: str = "jpg") -> CompressedImage:
        """Return an array, blue first, as the bytes of a file."""
        import cv2

        done, data = cv2.imencode(f".{dst_format}", cvim)
        if not done:
            raise CvBridgeError(f"images cannot be written as '{dst_format}'")
        return CompressedImage(format=dst_format, data=np.asarray(data, np.uint8).ravel())


def _format(encoding: str) -> tuple[int, np.dtype[Any]]:
    if encoding not in _CHANNELS:
        raise CvBridgeError(f"unknown encoding '{encoding}'; valid: {', '.join(_CHANNELS)}")
    bits = "16" if encoding == "mono16" else encoding[:2]
    return _CHANNELS[encoding], np.dtype(_TYPES.get(bits, "uint8"))


def _own_name(dtype: np.dtype[Any], channels: int) -> str:
    if dtype == np.uint8 or dtype.kind in "ib":
        return {1: "mono8", 3: "bgr8", 4: "bgra8"}[channels]
    return f"{8 * dtype.itemsize}{'U' if dtype.kind == 'u' else 'F'}C{channels}"


def _converted(picture: Picture, given: str, wanted: str) -> Picture:
    import cv2

    (_, before), (channels, after) = _format(given), _format(wanted)
    if before != after:
        raise CvBridgeError(f"images cannot be converted from '{given}' to '{wanted}'")
    if {given[:3], wanted[:3]} == {"rgb", "bgr"}:
        picture = picture[..., [2, 1, 0]]
    elif wanted in ("mono8", "8UC1") and picture.shape[2] >= 3:
        code = cv2.COLOR_RGB2GRAY if given[:3] == "rgb" else cv2.COLOR_BGR2GRAY
        return np.asarray(cv2.cvtColor(np.ascontiguousarray(picture[..., :3]), code), np.uint8)
    elif picture.shape[2] == 1 and channels == 3:
        picture = picture.repeat(3, axis=2)
    copied = np.array(picture, order="C")  # as OpenCV needs it to draw in
    return copied[..., 0] if copied.shape[2] == 1 else copied
