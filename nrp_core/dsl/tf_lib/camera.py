"""Conversions between pixels, the image plane and angles."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, atan, degrees, radians, sqrt, tan

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
