"""Images on surfaces. Scenes have the mean colour of an image, renderers show the image itself."""

from __future__ import annotations

import numpy as np


def mean_color(image: bytes | None) -> tuple[float, float, float] | None:
    """Return the mean red, green and blue of an image file, 0..1; None if it is missing or unreadable."""
    if not image:
        return None
    import cv2

    try:
        pixels = cv2.imdecode(np.frombuffer(image, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    if pixels is None:
        return None
    blue, green, red = (float(part) / 255 for part in pixels.reshape(-1, 3).mean(axis=0))
    return red, green, blue
