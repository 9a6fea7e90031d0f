"""Textures: a surface with a picture is shown in the picture's mean colour."""

from __future__ import annotations

import numpy as np


def mean_color(picture: bytes | None) -> tuple[float, float, float] | None:
    """Return red, green and blue from 0 to 1; None where there is no picture, or one that cannot be read."""
    if not picture:
        return None
    import cv2

    try:
        pixels = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    if pixels is None:
        return None
    blue, green, red = (float(part) / 255 for part in pixels.reshape(-1, 3).mean(axis=0))
    return red, green, blue
