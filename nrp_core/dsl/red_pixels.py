"""Count the red pixels of an image without an image of its hues.

A pixel is red if, in OpenCV's 8-bit HSV (``cv2.COLOR_RGB2HSV``), it has hue 0, and saturation and value of at
least 30. In whole numbers that is the condition of :func:`_is_red`, for each of the 2**24 colours.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core._support.jit import inlined, jit

Pixels = npt.NDArray[np.uint8]

_BLOCK = 8
"""Pixels that are compared at once with those before them, as three words."""


def count_red(pixels: Pixels) -> tuple[int, int]:
    """Return the number of red pixels in the left and the right half of an image.

    Args:
        pixels: RGB, shape ``(height, width, 3)``; of an odd width, the right half is larger.
    """
    height, width, _ = pixels.shape
    half = width // 2
    if width % (2 * _BLOCK) or not pixels.flags.c_contiguous:
        return int(_count(pixels[:, :half])), int(_count(pixels[:, half:]))
    words = pixels.reshape(height, 3 * width).view(np.uint64)
    left, both = _count_blocks(pixels, words)
    return int(left), int(both - left)


def red_colors(colors: Pixels) -> npt.NDArray[np.bool_]:
    """Return which colours are red.

    Args:
        colors: RGB, shape ``(n, 3)``.
    """
    return np.array([_count(color.reshape(1, 1, 3)) for color in colors], bool)


@inlined
def _is_red(red: int, green: int, blue: int) -> bool:
    """Return whether a colour is red, by the largest channel, the saturation and the rounded hue."""
    chroma, aside = red - min(green, blue), 60 * (green - blue)
    is_rounded = (aside < chroma) & (-aside <= chroma - (chroma == 180))
    # without branches: in an image with noise, half of them would be mispredicted
    return (red >= 30) & (red >= green) & (red >= blue) & is_rounded & (510 * chroma >= 59 * red)


@jit
def _count_blocks(pixels: Pixels, words: npt.NDArray[np.uint64]) -> tuple[int, int]:
    """Return the number of red pixels in the left half and in all; a block like the last has its number."""
    height, width, _ = pixels.shape
    left = both = found = 0
    a = b = c = np.uint64(0)  # black
    for row in range(height):
        for block in range(width // _BLOCK):
            x, y, z = words[row, 3 * block], words[row, 3 * block + 1], words[row, 3 * block + 2]
            if x != a or y != b or z != c:
                a, b, c, found = x, y, z, 0
                for column in range(_BLOCK * block, _BLOCK * (block + 1)):
                    pixel = pixels[row, column]
                    found += _is_red(int(pixel[0]), int(pixel[1]), int(pixel[2]))
            both += found
            if 2 * _BLOCK * block < width:
                left += found
    return left, both


@jit
def _count(pixels: Pixels) -> int:
    found = 0
    for row in range(pixels.shape[0]):
        for column in range(pixels.shape[1]):
            pixel = pixels[row, column]
            found += _is_red(int(pixel[0]), int(pixel[1]), int(pixel[2]))
    return found
