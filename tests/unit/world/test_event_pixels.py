"""Pixels of an event camera follow the definition: an event for each threshold of change."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nrp_core.world.sensors.event_camera import Pixels

MS = 1_000_000


def test_an_even_change_gives_events_at_even_times_by_the_threshold_of_each_pixel():
    pixels = Pixels(np.array([[0.25, 0.5, 2.0]]))
    assert pixels.see(np.zeros((1, 3)), 0).x.size == 0
    events = pixels.see(np.array([[1.0, -1.0, 1.0]]), 20 * MS)
    assert list(zip(events.t_ns // MS, events.x, events.polarity, strict=True)) == [
        (5, 0, 1), (10, 0, 1), (10, 1, 0), (15, 0, 1), (20, 0, 1), (20, 1, 0)
    ]  # fmt: skip


def test_small_changes_add_up_and_a_still_pixel_is_silent():
    pixels = Pixels(np.full((1, 1), 0.3))
    counts = [
        pixels.see(np.full((1, 1), level), n * MS).x.size for n, level in enumerate((0.0, 0.2, 0.4, 0.4))
    ]
    assert counts == [0, 0, 1, 0]


IMAGES = arrays(float, (5, 2, 3), elements=st.floats(-6, 0))


@given(images=IMAGES, thresholds=arrays(float, (2, 3), elements=st.floats(0.05, 1)))
def test_events_tell_the_brightness_within_a_threshold(images, thresholds):
    pixels, told, last_ns = Pixels(thresholds), images[0].copy(), 0
    for number, image in enumerate(images):
        events = pixels.see(image, number * MS)
        np.add.at(told, (events.y, events.x), (2 * events.polarity - 1) * thresholds[events.y, events.x])
        assert (np.abs(told - image) <= thresholds + 1e-9).all()
        assert (np.diff(events.t_ns) >= 0).all()
        assert ((events.t_ns >= last_ns) & (events.t_ns <= number * MS)).all()
        last_ns = number * MS
