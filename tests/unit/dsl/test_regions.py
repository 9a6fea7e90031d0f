"""Selectors by location choose what a search through all positions would choose."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core import dsl as nrp
from nrp_core.dsl.selection import BrainRoot, Selection, evaluate, select
from nrp_core.dsl.testing import MockBrain, Rig
from nrp_core.errors import NeuronSelectionError
from nrp_core.network.data import Network, Population
from nrp_core.network.pynn import builder

FIRST = 3
coordinates = st.integers(-20, 20).map(lambda n: n / 4)
points = st.lists(coordinates, min_size=2, max_size=3)
places = st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=12)


def root(positions: Any) -> BrainRoot:
    array = np.array(positions, dtype=float)
    cells = Population("cells", len(array), "Cell", {}, positions_um=array)
    return BrainRoot(
        Network({"other": Population("other", FIRST, "Cell", {}), "cells": cells},
                views={"backwards": np.arange(FIRST, FIRST + len(array))[::-1]})
    )  # fmt: skip


def chosen(selector: Any, brain: BrainRoot) -> list[int]:
    found = evaluate(selector, brain)
    assert isinstance(found, Selection)
    return (found.ids - FIRST).tolist()


@given(places, points, points)
def test_a_box_holds_what_lies_between_its_corners(positions: Any, one: Any, other: Any) -> None:
    corners = list(zip(one, other, strict=False))
    low, high = [min(pair) for pair in corners], [max(pair) for pair in corners]
    inside = [
        i for i, place in enumerate(positions)
        if all(a <= x <= b for a, x, b in zip(low, place, high, strict=False))
    ]  # fmt: skip
    brain, box = root(positions), nrp.Box(low, high)
    assert chosen(nrp.brain.cells.within(box), brain) == inside
    assert chosen(nrp.brain.backwards.within(box), brain) == inside[::-1]


@given(places, points, st.integers(0, 40).map(lambda n: n / 4))
def test_a_sphere_holds_what_is_not_farther_than_its_radius(
    positions: Any, center: Any, radius: float
) -> None:
    distances = [math.dist(place[: len(center)], center) for place in positions]
    found = chosen(nrp.brain.cells.within(nrp.Sphere(center, radius)), root(positions))
    assert set(found) >= {i for i, distance in enumerate(distances) if distance < radius - 1e-9}
    assert set(found) <= {i for i, distance in enumerate(distances) if distance <= radius + 1e-9}


@given(places, points, st.data())
def test_the_nearest_are_those_with_the_smallest_distances(positions: Any, center: Any, data: Any) -> None:
    n = data.draw(st.integers(1, len(positions)))
    squares = [sum((x - c) ** 2 for x, c in zip(place, center, strict=False)) for place in positions]
    expected = sorted(range(len(positions)), key=lambda i: squares[i])[:n]
    assert chosen(nrp.brain.cells.nearest(center, n), root(positions)) == expected


@given(places, st.integers(0, 11), st.integers(0, 11))
def test_a_choice_by_location_is_a_selector_like_any_other(positions: Any, a: int, b: int) -> None:
    brain, size = root(positions), len(positions)
    whole = nrp.brain.cells.within(nrp.Box((-math.inf, -math.inf), (math.inf, math.inf)))
    assert chosen(whole, brain) == list(range(size))
    assert chosen(whole[a % size] + nrp.brain.cells[b % size], brain) == [a % size, b % size]
    assert evaluate(whole.size - 1, brain) == size - 1
    assert chosen(nrp.brain.cells[::2].nearest((0, 0), nrp.brain.cells[::2].size)[:1], brain)[0] % 2 == 0


def test_positions_come_from_the_script_and_devices_take_the_choice() -> None:
    sim = builder()
    sim.Population((4, 5), sim.IF_curr_exp(), label="sheet")

    @nrp.MapSpikeSource("eye", nrp.brain.sheet.within(nrp.Sphere((0, 0), 1.0)), nrp.poisson)
    @nrp.MapSpikeSink(
        "row", nrp.map_neurons(4, lambda i: nrp.brain.sheet.nearest((i, 4))), nrp.population_rate
    )
    @nrp.Robot2Neuron()
    def look(t: float, eye: Any, row: Any) -> None:
        eye.rate = 5.0

    Rig(look, MockBrain(sim.network())).run()
    assert look.adapters["eye"].selection.ids.tolist() == [0, 1, 5]
    assert [device.selection.ids.tolist() for device in look.adapters["row"]] == [[4], [9], [14], [19]]


def test_a_selector_shows_what_it_means() -> None:
    assert repr(nrp.brain.cells.within(nrp.Box((0, 0), (1, math.inf)))) == (
        "brain.cells.within(Box((0, 0), (1, inf)))"
    )
    assert repr(nrp.brain.cells.nearest((0, 1, 2.5), 3)) == "brain.cells.nearest((0, 1, 2.5), 3)"
    assert repr(nrp.Sphere((0, 0, 1), 50)) == "Sphere((0, 0, 1), 50)"


@pytest.mark.parametrize(
    "choose",
    [
        lambda: nrp.Box((0, 0), (1,)),
        lambda: nrp.Box((0, 0), (1, 1, 1)),
        lambda: nrp.Box((0, 5), (1, 1)),
        lambda: nrp.Box((0, math.nan), (1, 1)),
        lambda: nrp.Box("corner", (1, 1)),
        lambda: nrp.Sphere((0, math.inf), 1),
        lambda: nrp.Sphere((0, 0), -1),
        lambda: nrp.Sphere((0, 0), math.nan),
    ],
)
def test_a_region_that_is_none_is_refused_where_it_is_written(choose: Any, golden: Golden) -> None:
    with golden.raises(NeuronSelectionError):
        choose()


@pytest.mark.parametrize(
    ("selector", "message"),
    [
        (nrp.brain.cells.within(nrp.Box((5, 5), (6, 6))), r"brain\.cells\.within\(Box"),
        (nrp.brain.cells.within((0, 0)), r"\(0, 0\)"),
        (nrp.brain.cells.nearest((0, 0), 9), "'cells'"),
        (nrp.brain.cells.nearest((0, 0), 0), ""),
        (nrp.brain.cells.nearest(3, 1), ""),
        (nrp.brain.cells.size.nearest((0, 0)), r"brain\.cells\.size"),
        (nrp.brain.other.nearest((0, 0)), "'other'"),
        ((nrp.brain.cells + nrp.brain.other).within(nrp.Box((0, 0), (1, 1))), "'other'"),
    ],
)  # fmt: skip
def test_an_invalid_selector_is_refused_with_the_reason(selector: Any, message: str, golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match=message):
        select(selector, root([(0, 0, 0), (1, 1, 1)]))


def test_positions_are_part_of_a_network_that_is_the_same_or_not() -> None:
    cells = Population("cells", 2, "Cell", {}, positions_um=np.zeros((2, 3)))
    moved = replace(cells, positions_um=np.ones((2, 3)))
    assert Network({"cells": cells}).digest != Network({"cells": moved}).digest
