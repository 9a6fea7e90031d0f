"""Red pixels are those of OpenCV's HSV."""

import cv2
import numpy as np
import pytest

from nrp_core.dsl.red_pixels import count_red, red_colors


def red_of_opencv(pixels):
    hsv = cv2.cvtColor(pixels, cv2.COLOR_RGB2HSV)
    return cv2.inRange(hsv, np.array((0, 30, 30), np.uint8), np.array((0, 255, 255), np.uint8)) > 0


def halves(mask):
    middle = mask.shape[1] // 2
    return int(mask[:, :middle].sum()), int(mask[:, middle:].sum())


@pytest.mark.parametrize("red", range(0, 256, 5))
def test_every_colour_counts_as_opencv_says(red):
    green, blue = np.meshgrid(np.arange(256), np.arange(256), indexing="ij")
    colours = np.stack([np.full_like(green, red), green, blue], axis=-1).astype(np.uint8)
    for row, expected in zip(colours, red_of_opencv(colours), strict=True):
        assert count_red(row[np.newaxis]) == halves(expected[np.newaxis])


@pytest.mark.parametrize("width", [1, 2, 15, 16, 40, 320])
def test_the_halves_of_an_image_of_any_width_are_counted(width):
    random = np.random.default_rng(width)
    palette = np.array([(200, 0, 0), (255, 255, 255), (0, 0, 0), (40, 30, 29)], np.uint8)
    image = palette[np.repeat(random.integers(0, 4, (24, width)), 3, axis=0)]
    assert count_red(image) == halves(red_of_opencv(image))
    assert count_red(image[:, ::-1]) == halves(red_of_opencv(image[:, ::-1].copy()))


def test_the_red_ones_of_some_colours_are_those_of_their_pixels():
    colours = np.random.default_rng(1).integers(0, 256, (2000, 3), np.uint8)
    colours[:, 1:] //= 3
    found = red_colors(colours)
    assert found.tolist() == red_of_opencv(colours[np.newaxis])[0].tolist()
    assert found.any()
