"""Camera images as JPEG files, for recordings with compressed images."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.errors import ExperimentError
from nrp_core.messages.cv_bridge import CvBridge, CvBridgeError
from nrp_core.messages.sensor_msgs import CompressedImage, Image

Pixels = npt.NDArray[np.uint8]

QUALITY = 90
_CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1}


def compressible(image: Image) -> bool:
    """Return whether JPEG can hold an image of this encoding."""
    return image.encoding in _CHANNELS and image.width > 0 and image.height > 0


def compress(image: Image) -> CompressedImage:
    """Return an image as JPEG."""
    cv2 = _opencv()
    pixels = _reshape(image)
    if image.encoding == "rgb8":
        pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)  # three times as fast as reversing the axis
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return CompressedImage(image.header, "jpeg", data.reshape(-1))


def pixels_of(image: Image | CompressedImage) -> Pixels:
    """Return the pixels of a recorded image, shape ``(height, width, 3)``, RGB; depths as greys."""
    values = values_of(image)
    if values.dtype != np.uint8:
        values = _greys(values)
    return np.repeat(values[..., np.newaxis], 3, axis=2) if values.ndim == 2 else values[..., :3]


def values_of(image: Image | CompressedImage) -> npt.NDArray[Any]:
    """Return the values of a recorded image: RGB, or one value per pixel, such as depths in m."""
    if isinstance(image, CompressedImage):
        return _decode(image)[:, :, ::-1]
    values = as_it_was(image).data
    return values[:, :, ::-1] if image.encoding == "bgr8" else values


def as_it_was(image: Image) -> Image:
    """Return a recorded image with the original shape and type of its data."""
    try:
        return replace(image, data=CvBridge().imgmsg_to_cv2(image))
    except (CvBridgeError, ValueError) as error:
        raise ExperimentError(f"an image in the encoding '{image.encoding}' cannot be read") from error


def _greys(values: npt.NDArray[Any]) -> Pixels:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    far = np.clip(
        (np.nan_to_num(values, nan=high, posinf=high, neginf=low) - low) / (high - low or 1.0), 0, 1
    )
    return np.asarray(255 * (1 - far), np.uint8)


def _reshape(image: Image) -> Pixels:
    shape = (image.height, image.width, _CHANNELS[image.encoding])
    return np.asarray(image.data, np.uint8).reshape(shape)


def _decode(image: CompressedImage) -> Pixels:
    """Return the pixels of an image file, BGR; a black pixel if it is broken."""
    cv2 = _opencv()
    decoded = cv2.imdecode(np.frombuffer(image.data, np.uint8), cv2.IMREAD_COLOR)
    return np.zeros((1, 1, 3), np.uint8) if decoded is None else np.asarray(decoded, np.uint8)


def _opencv() -> Any:
    """Import OpenCV at the first image, because the import is slow."""
    import cv2

    return cv2
