"""Points that a camera sees, from its depth and colours."""

from __future__ import annotations

import numpy as np

from nrp_core.world.messages.point_cloud2 import create_cloud
from nrp_core.world.messages.sensor_msgs import PointCloud2
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.render.cameras import DepthArray, ImageArray

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<f4")])
"""A point in the frame of the images, and its colour, whose bytes are those of the number 0xRRGGBB."""


def cloud_of(header: Header, depth: DepthArray, image: ImageArray, focal: float) -> PointCloud2:
    """Return a row of points for each row of an image; NaN where there is nothing to see.

    Args:
        header: their time and frame.
        depth: shape ``(height, width)``, m.
        image: of the same size.
        focal: focal length, pixels.
    """
    height, width = depth.shape
    points = np.zeros(depth.shape, POINT)
    ahead = np.where(np.isfinite(depth), depth, np.nan)
    points["x"] = (np.arange(width) + 0.5 - width / 2) / focal * ahead
    points["y"] = ((np.arange(height) + 0.5 - height / 2) / focal)[:, None] * ahead
    points["z"] = ahead
    red, green, blue = (image[..., channel].astype("<u4") for channel in range(3))
    points["rgb"] = (red << 16 | green << 8 | blue).view("<f4")
    return create_cloud(header, points)
