"""OpenCV, which refuses images that announce more pixels than any camera takes, before it allocates them."""

from __future__ import annotations

import os
from typing import Any, Final

MAX_PIXELS: Final = 1 << 26
"""The largest image that is read: 8192 by 8192 pixels, 200 MB in three colours."""

# OpenCV reads it once, when it is loaded
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MAX_PIXELS))

import cv2 as cv2  # noqa: E402
import numpy as np  # noqa: E402


def decode(image: bytes, flags: int) -> Any:
    """Return the pixels of an image file; None if it is no image, or too large.

    Args:
        image: the contents of the file.
        flags: OpenCV's, such as ``cv2.IMREAD_COLOR``.
    """
    try:
        pixels = cv2.imdecode(np.frombuffer(image, np.uint8), flags)
    except cv2.error:
        return None
    return pixels
