"""Colours in camera images. OpenCV does the work and is loaded at the first image."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard, cast

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.messages.sensor_msgs import Image

ByteArray = npt.NDArray[np.uint8]

RED_HSV = ((0, 30, 30), (0, 255, 255))
"""The HSV range that :func:`detect_red` counts as red, in OpenCV's 8-bit HSV (hue 0..179)."""

_HSV = ("hue", "saturation", "value")
_CHANNELS = {"rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4, "8UC4": 4, "mono8": 1, "8UC1": 1}


@dataclass(frozen=True, slots=True)
class RedShares:
    """The shares of red in an image.

    Attributes:
        left, right: red share of each half, 0..1.
        go_on: share of the whole image that is not red, 0..1.
        leftred, rightred, greenblue: the same under other names.
    """

    left: float = 0.0
    right: float = 0.0
    go_on: float = 0.0

    @property
    def leftred(self) -> float:
        """Same as ``left``."""
        return self.left

    @property
    def rightred(self) -> float:
        """Same as ``right``."""
        return self.right

    @property
    def greenblue(self) -> float:
        """Same as ``go_on``."""
        return self.go_on


def detect_red(image: Image | None) -> RedShares:
    """Return the share of red in the left and right half of an image.

    A pixel is red when its HSV values (8-bit, as OpenCV has them) have hue 0, saturation and value
    at least 30. An image of odd width has the larger half on the right.

    Args:
        image: in any of ROS's 8-bit encodings; None or an empty image gives zeros.
    """
    if not _has_pixels(image):
        return RedShares()
    import cv2

    mask = _matching(image, *RED_HSV)
    half = mask.shape[1] // 2
    red_left = cv2.countNonZero(mask[:, :half]) if half else 0
    red_right = cv2.countNonZero(mask[:, half:])
    size = mask.size
    return RedShares(2.0 * red_left / size, 2.0 * red_right / size, (size - red_left - red_right) / size)


@dataclass(frozen=True, slots=True)
class ColorValues:
    """Intensities of a resized image, by half and channel, in rows, shape ``(width / 2 * height,)``."""

    left_red: FloatArray
    left_green: FloatArray
    left_blue: FloatArray
    right_red: FloatArray
    right_green: FloatArray
    right_blue: FloatArray


def get_color_values(image: Image | None, width: int = 40, height: int = 30) -> ColorValues:
    """Return the colours of an image resized to ``width`` x ``height``, on an exponential scale for neurons.

    A channel value ``v`` in 0..255 becomes ``5000 ** (v / 256) / 5000``.

    Args:
        image: None or an empty image gives zeros.
        width: in pixels; the left half has ``width // 2`` columns.
        height: in pixels.
    """
    values = np.zeros((height, width, 3))
    if _has_pixels(image):
        import cv2

        values[:] = 5000.0 ** (cv2.resize(rgb_array(image), (width, height)) / 256.0) / 5000.0
    halves = (values[:, : width // 2], values[:, width // 2 :])
    return ColorValues(*(half[:, :, channel].ravel() for half in halves for channel in range(3)))


def find_centroid_hsv(
    image: Image | None, lower: Sequence[int], upper: Sequence[int]
) -> tuple[int, int] | None:
    """Return the mean pixel (column, row) of all pixels within HSV bounds, or None if there are none.

    Bounds that no pixel can meet are reported by a warning of Python, once for each line.

    Args:
        image: None gives None.
        lower: smallest hue (0..179), saturation and value (0..255), inclusive.
        upper: largest hue, saturation and value, inclusive.
    """
    if not _has_pixels(image):
        return None
    if wrong := wrong_bounds(lower, upper):
        warnings.warn(f"find_centroid_hsv: no colour is found: {wrong}", stacklevel=2)
    rows, columns = np.nonzero(_matching(image, lower, upper))
    return (int(columns.mean()), int(rows.mean())) if len(rows) else None


def wrong_bounds(lower: Sequence[float], upper: Sequence[float]) -> str:
    """Return why no pixel is within HSV bounds, or what is wrong with them; empty if nothing is."""
    if (len(lower), len(upper)) != (3, 3):
        return f"bounds are hue, saturation and value, not {len(lower)} and {len(upper)} numbers"
    for name, low, high, largest in zip(_HSV, lower, upper, (179, 255, 255), strict=True):
        if not (0 <= low <= 255 and 0 <= high <= 255) or low > largest:
            return f"{name} is 0 to {largest}, not {low:g} to {high:g}"
        if low > high:
            return f"the lower {name}, {low:g}, is above the upper one, {high:g}"
        is_share = name != "hue" and 0 < high <= 1
        if is_share or low != int(low) or high != int(high):
            return f"{name} is a whole number up to {largest}, not {low:g} to {high:g}"
    return ""


def rgb_array(image: Image) -> ByteArray:
    """Return an image as an array of shape ``(height, width, 3)``, without a copy if possible.

    Raises:
        ValueError: the encoding is not an 8-bit one.
    """
    if image.encoding not in _CHANNELS:
        raise ValueError(f"cannot read images encoded '{image.encoding}'; valid: {', '.join(_CHANNELS)}")
    import cv2

    pixels = _pixels(image, _CHANNELS[image.encoding])
    if image.encoding == "rgb8":
        return pixels
    if pixels.shape[2] == 1:
        return np.repeat(pixels, 3, axis=2)
    code = {"rgba8": cv2.COLOR_RGBA2RGB, "bgra8": cv2.COLOR_BGRA2RGB, "8UC4": cv2.COLOR_BGRA2RGB}
    return cast(ByteArray, cv2.cvtColor(pixels, code.get(image.encoding, cv2.COLOR_BGR2RGB)))


def _pixels(image: Image, channels: int) -> ByteArray:
    data = image.data if isinstance(image.data, np.ndarray) else np.frombuffer(bytes(image.data), np.uint8)
    if data.shape == (image.height, image.width, channels):
        return data
    step = image.step or image.width * channels
    rows = data.reshape(image.height, step)[:, : image.width * channels]
    return np.ascontiguousarray(rows).reshape(image.height, image.width, channels)


def _matching(image: Image, lower: Sequence[int], upper: Sequence[int]) -> ByteArray:
    import cv2

    hsv = cv2.cvtColor(rgb_array(image), cv2.COLOR_RGB2HSV)
    return cast(ByteArray, cv2.inRange(hsv, np.asarray(lower, np.uint8), np.asarray(upper, np.uint8)))


def _has_pixels(image: Image | None) -> TypeGuard[Image]:
    return image is not None and image.width > 0 and image.height > 0
