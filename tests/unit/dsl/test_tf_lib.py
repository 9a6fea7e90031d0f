"""The library functions give the documented numbers."""

from __future__ import annotations

from math import isclose

import cv2
import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.dsl.tf_lib import (
    PinholeCamera,
    RedShares,
    detect_red,
    find_centroid_hsv,
    get_color_values,
    rgb_array,
)
from nrp_core.messages.sensor_msgs import Image

RED = (255, 0, 0)


def image_of(pixels: np.ndarray, encoding: str = "rgb8") -> Image:
    height, width = pixels.shape[:2]
    step = pixels.strides[0]
    return Image(height=height, width=width, encoding=encoding, step=step, data=pixels)


def plain(color: tuple[int, int, int], width: int = 320, height: int = 240) -> Image:
    return image_of(np.full((height, width, 3), color, np.uint8))


def noise(seed: int, width: int = 64, height: int = 48) -> Image:
    shape = (height, width, 3)
    return image_of(np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8))


@pytest.mark.parametrize(
    ("color", "shares"),
    [
        (RED, RedShares(1.0, 1.0, 0.0)),
        ((255, 255, 0), RedShares(0.0, 0.0, 1.0)),
        ((255, 127, 127), RedShares(1.0, 1.0, 0.0)),
        ((30, 0, 0), RedShares(1.0, 1.0, 0.0)),
        ((29, 0, 0), RedShares(0.0, 0.0, 1.0)),
        ((255, 0, 9), RedShares(0.0, 0.0, 1.0)),
        ((128, 128, 128), RedShares(0.0, 0.0, 1.0)),
    ],
)
def test_red_is_hue_0_with_saturation_and_value_from_30_on(
    color: tuple[int, int, int], shares: RedShares
) -> None:
    assert detect_red(plain(color)) == shares


def test_both_namings_of_the_red_shares_are_the_same() -> None:
    pixels = np.zeros((240, 320, 3), np.uint8)
    pixels[:, 160:240] = RED
    shares = detect_red(image_of(pixels))
    assert (shares.leftred, shares.rightred, shares.greenblue) == (0.0, 0.5, 0.75)
    assert (shares.left, shares.right, shares.go_on) == (0.0, 0.5, 0.75)


@pytest.mark.parametrize("image", [None, Image(), Image(width=3)])
def test_without_pixels_nothing_is_red_and_nothing_is_not(image: Image | None) -> None:
    assert detect_red(image) == RedShares(0.0, 0.0, 0.0)
    assert find_centroid_hsv(image, (0, 0, 0), (179, 255, 255)) is None
    assert get_color_values(image).left_red.tolist() == [0.0] * 600


@pytest.mark.parametrize("width", [1, 2, 3, 5])
def test_narrow_images_are_split_at_half_the_width(width: int) -> None:
    pixels = np.zeros((3, width, 3), np.uint8)
    pixels[:, : width // 2] = RED
    shares = detect_red(image_of(pixels))
    assert (shares.left, shares.right) == (2 * (width // 2) / width, 0.0)


@given(seed=st.integers(0, 10_000))
def test_the_shares_count_the_pixels_that_opencv_puts_into_the_range(seed: int) -> None:
    image = noise(seed)
    hue, saturation, value = np.moveaxis(cv2.cvtColor(image.data, cv2.COLOR_RGB2HSV), 2, 0)
    red = (hue == 0) & (saturation >= 30) & (value >= 30)
    left, right = red[:, :32].sum(), red[:, 32:].sum()
    size = red.size
    assert detect_red(image) == RedShares(2 * left / size, 2 * right / size, (size - left - right) / size)


@pytest.mark.parametrize(
    ("encoding", "order"), [("bgr8", [2, 1, 0]), ("rgba8", [0, 1, 2, 0]), ("bgra8", [2, 1, 0, 0])]
)
def test_encodings_are_read_in_their_channel_order(encoding: str, order: list[int]) -> None:
    image = noise(1)
    coded = image_of(np.ascontiguousarray(image.data[:, :, order]), encoding)
    assert np.array_equal(rgb_array(coded), image.data)


def test_grey_images_have_three_equal_channels() -> None:
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4, 1)
    assert np.array_equal(rgb_array(image_of(grey, "mono8")), np.repeat(grey, 3, axis=2))


def test_flat_and_padded_buffers_are_read_row_by_row() -> None:
    pixels = noise(2, width=5, height=4).data
    padded = np.zeros((4, 18), np.uint8)
    padded[:, :15] = pixels.reshape(4, 15)
    for data in (padded.ravel(), padded.tobytes()):
        image = Image(height=4, width=5, encoding="rgb8", step=18, data=data)  # type: ignore[arg-type]
        assert np.array_equal(rgb_array(image), pixels)


def test_an_unknown_encoding_is_refused(golden: Golden) -> None:
    with golden.raises(ValueError, match="'yuv422'"):
        detect_red(Image(width=2, height=2, encoding="yuv422"))


def test_color_values_are_steep_and_split_by_half_and_channel() -> None:
    pixels = np.zeros((30, 40, 3), np.uint8)
    pixels[:, :20, 0] = 255
    pixels[0, 39, 2] = 128
    values = get_color_values(image_of(pixels))
    dark, bright = 1 / 5000, 5000 ** (255 / 256) / 5000
    assert values.left_red.shape == (600,)
    assert np.allclose(values.left_red, bright)
    assert np.allclose(values.right_red, dark)
    assert values.right_blue.reshape(30, 20)[0, 19] == 5000**0.5 / 5000
    assert np.allclose(np.delete(values.right_blue, 19), dark)


def test_color_values_shrink_larger_images() -> None:
    values = get_color_values(plain((0, 255, 0)), width=10, height=6)
    assert values.left_green.shape == (30,)
    assert np.allclose(values.left_green, 5000 ** (255 / 256) / 5000)


def test_the_centroid_is_the_mean_pixel_of_a_colour() -> None:
    pixels = np.zeros((240, 320, 3), np.uint8)
    pixels[100:121, 40:61] = (0, 255, 0)
    green = ((50, 50, 50), (70, 255, 255))
    assert find_centroid_hsv(image_of(pixels), *green) == (50, 110)
    assert find_centroid_hsv(plain(RED), *green) is None


def test_the_camera_has_the_documented_calibration() -> None:
    camera = PinholeCamera()
    assert (camera.width, camera.height, camera.fx, camera.cx, camera.cy) == (320, 240, 160, 160, 120)
    assert camera.pixel2metric(320, 240) == (1.0, 0.75)
    assert camera.pixel2norm(320, 0) == (1.0, -1.0)
    azimuth, elevation = camera.pixel2angle(0, 120)
    assert isclose(azimuth, 45.0)
    assert elevation == 0.0


def test_another_image_size_rescales_the_calibration() -> None:
    camera = PinholeCamera()
    assert camera.set_image_size(640, 120)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (320, 80, 320, 60)
    assert not camera.set_image_size(0, 120)
    assert (camera.width, camera.height) == (640, 120)


@given(
    u=st.floats(-200, 600), v=st.floats(-200, 600), width=st.integers(1, 2000), height=st.integers(1, 2000)
)
def test_conversions_there_and_back_are_the_identity(u: float, v: float, width: int, height: int) -> None:
    camera = PinholeCamera()
    camera.set_image_size(width, height)
    metric, angle, norm = camera.pixel2metric(u, v), camera.pixel2angle(u, v), camera.pixel2norm(u, v)
    for back in (camera.metric2pixel(*metric), camera.angle2pixel(*angle), camera.norm2pixel(*norm)):
        assert np.allclose(back, (u, v), atol=1e-6)
    assert np.allclose(camera.norm2metric(*norm), metric, atol=1e-6)
    assert np.allclose(camera.norm2angle(*norm), angle, atol=1e-6)
    assert np.allclose(camera.angle2metric(*angle), metric, atol=1e-6)


@pytest.mark.parametrize("bounds", [((200, 0, 0), (220, 255, 255)), ((90, 0.5, 0), (100, 255, 255))])
def test_bounds_that_no_pixel_meets_are_reported_at_the_line_that_gives_them(
    bounds: tuple[tuple[float, ...], tuple[float, ...]],
) -> None:
    with pytest.warns(UserWarning, match="no colour is found: (hue|saturation) is") as caught:
        assert find_centroid_hsv(plain(RED), *bounds) is None or bounds[0][1] == 0.5
    assert caught[0].filename == __file__
