"""``CvBridge`` as in ROS: converts images between messages and arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.messages.sensor_msgs import CompressedImage, Image

CvArray = npt.NDArray[Any]

_CHANNELS = {
    "mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4, "8UC4": 4,
    "mono16": 1, "16UC1": 1, "16UC3": 3, "32FC1": 1, "32FC3": 3, "64FC1": 1,
}  # fmt: skip
_TYPES = {"16": "uint16", "32": "float32", "64": "float64"}
_PASS = "passthrough"


class CvBridgeError(TypeError):
    """The encoding is unknown or cannot be converted."""


class CvBridge:
    """Converts between messages and arrays of shape ``(height, width)`` or ``(height, width, channels)``."""

    def imgmsg_to_cv2(self, img_msg: Image, desired_encoding: str = _PASS) -> CvArray:
        """Return an image as a new array.

        Raises:
            CvBridgeError: an encoding is unknown, or the conversion does not exist.
        """
        channels, dtype = _format(img_msg.encoding)
        flat = np.frombuffer(np.ascontiguousarray(img_msg.data).tobytes(), dtype)
        image = flat.reshape(img_msg.height, -1)[:, : img_msg.width * channels]
        image = image.reshape(img_msg.height, img_msg.width, channels)
        wanted = img_msg.encoding if desired_encoding == _PASS else desired_encoding
        return _convert(image, img_msg.encoding, wanted)

    def cv2_to_imgmsg(self, cvim: CvArray, encoding: str = _PASS) -> Image:
        """Return an array as a message; without an encoding, the channels are in OpenCV's order (BGR).

        Raises:
            CvBridgeError: the encoding is unknown.
        """
        given = np.ascontiguousarray(cvim)
        height, width = given.shape[:2]
        channels = 1 if given.ndim == 2 else given.shape[2]
        name = encoding if encoding != _PASS else _own_name(given.dtype, channels)
        _, dtype = _format(name)
        image = given.astype(dtype, copy=False)
        return Image(
            height=height, width=width, encoding=name, step=width * channels * image.itemsize, data=image
        )

    def compressed_imgmsg_to_cv2(
        self, cmprs_img_msg: CompressedImage, desired_encoding: str = "bgr8"
    ) -> CvArray:
        """Decode the bytes of an image file to an array."""
        import cv2

        found = cv2.imdecode(np.frombuffer(bytes(cmprs_img_msg.data), np.uint8), cv2.IMREAD_COLOR)
        if found is None:
            raise CvBridgeError(f"these bytes are not an image of the format '{cmprs_img_msg.format}'")
        return _convert(np.asarray(found), "bgr8", "bgr8" if desired_encoding == _PASS else desired_encoding)

    def cv2_to_compressed_imgmsg(self, cvim: CvArray, dst_format: str = "jpg") -> CompressedImage:
        """Return an array in BGR order as the bytes of an image file."""
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


def _convert(image: CvArray, given: str, wanted: str) -> CvArray:
    import cv2

    (_, before), (channels, after) = _format(given), _format(wanted)
    if before != after:
        raise CvBridgeError(f"images cannot be converted from '{given}' to '{wanted}'")
    if {given[:3], wanted[:3]} == {"rgb", "bgr"}:
        image = image[..., [2, 1, 0]]
    elif wanted in ("mono8", "8UC1") and image.shape[2] >= 3:
        code = cv2.COLOR_RGB2GRAY if given[:3] == "rgb" else cv2.COLOR_BGR2GRAY
        return np.asarray(cv2.cvtColor(np.ascontiguousarray(image[..., :3]), code), np.uint8)
    elif image.shape[2] == 1 and channels == 3:
        image = image.repeat(3, axis=2)
    copied = np.array(image, order="C")  # OpenCV draws only in contiguous arrays
    return copied[..., 0] if copied.shape[2] == 1 else copied
