"""``nrp.tf_lib``: functions to call in transfer functions."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan, degrees, radians, sqrt, tan
from typing import TypeGuard, cast

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.dsl.afferents import NormalizedSpindle, NormalizedTendonOrgan, Spindle, TendonOrgan
from nrp_core.dsl.copies import for_copies
from nrp_core.messages.sensor_msgs import Image
from nrp_core.world.render.seen_image import SeenImage

__all__ = [
    "ColorValues",
    "NormalizedSpindle",
    "NormalizedTendonOrgan",
    "PinholeCamera",
    "RedShares",
    "Spindle",
    "TendonOrgan",
    "cam",
    "detect_red",
    "find_centroid_hsv",
    "get_color_values",
    "rgb_array",
]

Pair = tuple[float, float]


@dataclass
class PinholeCamera:
    """A pinhole camera.

    Pixels ``(u, v)`` count from the upper left; metric ``(x, y)`` lie on the plane at distance 1, x to
    the right and y down; angles (azimuth, elevation) in degrees are positive to the left and up;
    norm runs from -1 to 1 over the image.

    Args:
        cal_width, cal_height: image size of the calibration, pixels.
        cal_fx, cal_fy, cal_cx, cal_cy: focal lengths and centre at that size, pixels.
    """

    cal_width: int = 320
    cal_height: int = 240
    cal_fx: float = 160.0
    cal_fy: float = 160.0
    cal_cx: float = 160.0
    cal_cy: float = 120.0

    def __post_init__(self) -> None:
        self.width, self.height = self.cal_width, self.cal_height

    def set_image_size(self, width: int, height: int) -> bool:
        """Use images of another size. If the size is not positive, return False and change nothing."""
        if width <= 0 or height <= 0:
            return False
        self.width, self.height = width, height
        return True

    @property
    def fx(self) -> float:
        """Horizontal focal length, pixels."""
        return self.cal_fx * self.width / self.cal_width

    @property
    def fy(self) -> float:
        """Vertical focal length, pixels."""
        return self.cal_fy * self.height / self.cal_height

    @property
    def cx(self) -> float:
        """Column of the optical axis."""
        return self.cal_cx * self.width / self.cal_width

    @property
    def cy(self) -> float:
        """Row of the optical axis."""
        return self.cal_cy * self.height / self.cal_height

    def pixel2metric(self, u: float, v: float) -> Pair:
        """Convert pixels to the plane at distance 1."""
        return (u - self.cx) / self.fx, (v - self.cy) / self.fy

    def metric2pixel(self, x: float, y: float) -> Pair:
        """Convert from the plane at distance 1 to pixels."""
        return x * self.fx + self.cx, y * self.fy + self.cy

    def metric2angle(self, x: float, y: float) -> Pair:
        """Convert from the plane at distance 1 to angles."""
        return -degrees(atan(x)), -degrees(asin(y / sqrt(x * x + y * y + 1.0)))

    def angle2metric(self, azimuth: float, elevation: float) -> Pair:
        """Convert angles to the plane at distance 1."""
        x = -tan(radians(azimuth))
        return x, -tan(radians(elevation)) * sqrt(x * x + 1.0)

    def pixel2angle(self, u: float, v: float) -> Pair:
        """Convert pixels to angles."""
        return self.metric2angle(*self.pixel2metric(u, v))

    def angle2pixel(self, azimuth: float, elevation: float) -> Pair:
        """Convert angles to pixels."""
        return self.metric2pixel(*self.angle2metric(azimuth, elevation))

    def pixel2norm(self, u: float, v: float) -> Pair:
        """Convert pixels to -1..1."""
        return 2.0 * u / self.width - 1.0, 2.0 * v / self.height - 1.0

    def norm2pixel(self, x: float, y: float) -> Pair:
        """Convert -1..1 to pixels."""
        return (x + 1.0) / 2.0 * self.width, (y + 1.0) / 2.0 * self.height

    def norm2angle(self, x: float, y: float) -> Pair:
        """Convert -1..1 to angles."""
        return self.pixel2angle(*self.norm2pixel(x, y))

    def norm2metric(self, x: float, y: float) -> Pair:
        """Convert -1..1 to the plane at distance 1."""
        return self.pixel2metric(*self.norm2pixel(x, y))


cam = PinholeCamera()
"""The camera for scripts; each transfer function file gets its own under this name."""


ByteArray = npt.NDArray[np.uint8]

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


@for_copies
def detect_red(image: Image | None) -> RedShares:
    """Return the share of red in the left and right half of an image.

    A pixel is red when its HSV values (8-bit, as OpenCV has them) have hue 0, saturation and value
    at least 30. An image of odd width has the larger half on the right.

    Args:
        image: in any of ROS's 8-bit encodings; None or an empty image gives zeros.
    """
    if not _has_pixels(image):
        return RedShares()
    from nrp_core.dsl import red_pixels

    size = image.height * image.width
    counts = image.count_colors(red_pixels.red_colors) if isinstance(image, SeenImage) else None
    red_left, red_right = red_pixels.count_red(rgb_array(image)) if counts is None else counts
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


@for_copies
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


@for_copies
def find_centroid_hsv(
    image: Image | None, lower: Sequence[int], upper: Sequence[int]
) -> tuple[int, int] | None:
    """Return the mean pixel (column, row) of all pixels within HSV bounds, or None.

    Bounds that no pixel can meet are reported by a warning of Python, once for each line.

    Args:
        image: None gives None.
        lower: smallest hue (0..179), saturation and value (0..255), inclusive.
        upper: largest hue, saturation and value, inclusive.
    """
    if not _has_pixels(image):
        return None
    if wrong := wrong_bounds(lower, upper):
        warnings.warn(f"find_centroid_hsv: no colour is found: {wrong}", stacklevel=3)
    rows, columns = np.nonzero(_matching(image, lower, upper))
    return (int(columns.mean()), int(rows.mean())) if len(rows) else None


def wrong_bounds(lower: Sequence[float], upper: Sequence[float]) -> str:
    """Return why no pixel is within HSV bounds, or the mistake in the bounds; empty if they are valid."""
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
