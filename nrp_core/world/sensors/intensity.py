"""The intensity of light in an image, as a retina or an event camera responds to it."""

from __future__ import annotations

from math import log

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import ImageArray

LUMA = np.array([0.299, 0.587, 0.114]) / 255
"""Weights of red, green and blue in the intensity (ITU-R BT.601), which is 1 for white."""
DARK = 0.001
"""Added to the intensity, so that black has a logarithm."""
BLACK_TO_WHITE = log(1 + 1 / DARK)
"""The largest change of the logarithm."""


def log_intensity(image: ImageArray) -> FloatArray:
    """Return the logarithm of the intensity of each pixel, shape ``(height, width)``."""
    result: FloatArray = np.log(image @ LUMA + DARK)
    return result
