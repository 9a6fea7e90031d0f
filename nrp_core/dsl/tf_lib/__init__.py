"""``nrp.tf_lib``: functions to call in transfer functions."""

from __future__ import annotations

from nrp_core.dsl.tf_lib.camera import PinholeCamera, cam
from nrp_core.dsl.tf_lib.vision import (
    ColorValues,
    RedShares,
    detect_red,
    find_centroid_hsv,
    get_color_values,
    rgb_array,
)

__all__ = [
    "ColorValues",
    "PinholeCamera",
    "RedShares",
    "cam",
    "detect_red",
    "find_centroid_hsv",
    "get_color_values",
    "rgb_array",
]
