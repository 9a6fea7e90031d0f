"""Camera pictures as JPEG, which costs a tenth of the space and less time than writing them out."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from nrp_core.world.messages.sensor_msgs import CompressedImage, Image

QUALITY = 90
_CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1}


def compressible(image: Image) -> bool:
    """Return whether JPEG can hold a picture of this encoding."""
    return image.encoding in _CHANNELS and image.width > 0 and image.height > 0


def compress(image: Image) -> CompressedImage:
    """Return a picture as JPEG."""
    shape = (image.height, image.width, _CHANNELS[image.encoding])
    pixels: npt.NDArray[np.uint8] = np.asarray(image.data, np.uint8).reshape(shape)
    if image.encoding == "rgb8":
        pixels = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), np.uint8)  # three times a flip's speed
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return CompressedImage(image.header, "jpeg", data.reshape(-1))


def pixels_of(picture: Image | CompressedImage) -> npt.NDArray[np.uint8]:
    """Return the pixels of a recorded picture, shape ``(height, width, 3)``, RGB."""
    if isinstance(picture, CompressedImage):
        return _decoded(picture)[:, :, ::-1]
    shape = (picture.height, picture.width, _CHANNELS[picture.encoding])
    pixels = np.frombuffer(picture.data, np.uint8).reshape(shape)
    if picture.encoding == "mono8":
        return np.repeat(pixels, 3, axis=2)
    return pixels[:, :, ::-1] if picture.encoding == "bgr8" else pixels


def _decoded(picture: CompressedImage) -> npt.NDArray[np.uint8]:
    """Return the pixels of an image file, blue first; black where it is broken."""
    decoded = cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_COLOR)
    return np.zeros((1, 1, 3), np.uint8) if decoded is None else np.asarray(decoded, np.uint8)
