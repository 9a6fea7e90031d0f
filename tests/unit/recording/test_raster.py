"""Rasters of figures: the neurons that they show, and the names of their groups."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from nrp_core.recording.figures.story import Story
from nrp_core.recording.figures.traces import choose_neurons, draw_raster, rows_of, separate


@given(st.lists(st.integers(1, 200_000), min_size=1, max_size=30))
def test_a_raster_shows_all_neurons_of_small_groups_and_some_of_large_ones(sizes: list[int]) -> None:
    rows = rows_of(sizes)
    assert len(sizes) <= sum(rows) <= 400
    assert rows == [min(size, max(rows)) for size in sizes]
    assert rows == sizes or sum(min(size, max(rows) + 1) for size in sizes) > 400


@pytest.mark.parametrize(
    ("firing", "number", "shown"),
    [
        ({3, 700, 999}, 5, [0, 3, 499, 700, 999]),  # all that fire, then the silent ones from the first on
        (set(), 4, [0, 250, 500, 750]),
        (set(range(100, 300)), 4, [100, 150, 200, 250]),  # only such as fire
        (set(range(10)), 1000, list(range(1000))),
    ],
)
def test_a_sample_of_a_large_group_has_the_neurons_that_fire(
    firing: set[int], number: int, shown: list[int]
) -> None:
    assert choose_neurons(range(1000), firing, number) == shown


def test_a_sample_at_equal_distances_would_show_a_group_as_silent_that_fires() -> None:
    firing = {3, 700, 999}
    assert not firing & set(range(1000)[:: 1000 // 6])
    assert firing <= set(choose_neurons(range(1000), firing, 6))


def test_groups_of_a_raster_up_to_its_height_are_shown_whole() -> None:
    assert rows_of([20, 1, 379]) == [20, 1, 379]
    assert rows_of([20, 1, 100_000]) == [20, 1, 379]


@pytest.mark.parametrize(("groups_", "named"), [(14, 14), (40, 15)])
def test_a_raster_names_every_group_that_has_room_and_no_two_names_overlap(groups_: int, named: int) -> None:
    sizes = [390 - groups_, *[1] * groups_]
    populations = {f"group {i}": {"size": size} for i, size in enumerate(sizes[:groups_])}
    figure = Figure(figsize=(8, 1.7))
    axes = figure.add_axes((0.2, 0.0, 0.7, 1.0))
    draw_raster(axes, Story({"brain": {"populations": populations}}))
    names = [label for label in axes.get_yticklabels() if label.get_text()]
    assert len(names) == named
    heights = sorted(label.get_window_extent().y0 for label in names)
    assert min(np.diff(heights)) >= 0.99 * 8.0 * figure.dpi / 72  # lines of 8 points


@given(st.lists(st.floats(0, 100), min_size=1, max_size=9).map(sorted))
def test_labels_are_moved_apart_in_their_order_and_stay_within_the_panel(places: list[float]) -> None:
    moved = separate(places, 10.0, 100.0)
    assert moved[0] >= 0
    assert moved[-1] <= 100
    assert all(b - a >= 10 - 1e-9 for a, b in pairwise(moved))
    if all(b - a >= 10 for a, b in pairwise(places)):
        assert moved == places
