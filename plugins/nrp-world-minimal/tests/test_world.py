"""Footprints separate, robots slide along walls and do not pass through each other."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_conformance.world.kit import at, floor, prop, robot, twist
from nrp_world_minimal.engine import Footprint, MinimalBackend, way_out

from nrp_core.world import Box, Scene, WorldOptions

coordinates = st.floats(-1, 1)
sizes = st.floats(0.1, 2)


@st.composite
def rectangles(draw):
    x, y = draw(sizes), draw(sizes)
    points = np.array([(0, 0, 0), (x, y, 1)])
    return Footprint.around(points).at(draw(coordinates), draw(coordinates), draw(st.floats(-pi, pi)))


@given(rectangles(), rectangles())
def test_the_exit_is_a_round_trip_that_takes_no_time(mine, theirs):
    move = way_out(mine, theirs[None])
    assert np.linalg.norm(way_out(mine + move, theirs[None])) < 1e-9
    assert np.linalg.norm(move) <= 2 * np.hypot(2, 2)
    if np.linalg.norm(move) > 1e-9:  # smaller values are rounding
        assert way_out(mine + 0.9 * move, theirs[None]).any(), "a shorter way would have sufficed"


@given(st.lists(rectangles(), min_size=1, max_size=4), rectangles())
def test_of_several_the_deepest_is_left(others, mine):
    moves = [way_out(mine, other[None]) for other in others]
    longest = max(moves, key=np.linalg.norm)
    found = way_out(mine, np.array(others))
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(longest), abs=1e-9)


def driven(*models, seconds=3.0, **commands):
    backend = MinimalBackend()
    with backend.open(Scene(models), seed=1, options=WorldOptions()) as world:
        for step in range(round(seconds * 10)):
            for name, command in commands.items():
                world.advertise(f"/{name}/cmd_vel").publish(twist(*command))
            world.run_until((step + 1) * 100_000_000)
        return {name: world.model_motion(name).pose for name in commands}


def test_a_robot_slides_along_a_wall():
    wall = prop("wall", Box((20, 0.2, 2)), at(0, 1, 1))
    pose = driven(floor(), robot(yaw=0.4), wall, robot=(0.8, 0.0))["robot"]
    assert pose.position[0] == pytest.approx(2.4 * np.cos(0.4), abs=0.05)
    assert pose.position[1] < 0.65
    assert pose.yaw == pytest.approx(0.4)


def test_a_corner_stops_a_robot():
    walls = prop("a", Box((0.2, 9, 2)), at(1.5, 0, 1)), prop("b", Box((9, 0.2, 2)), at(0, 1.5, 1))
    x, y, _ = driven(floor(), robot(yaw=pi / 4), *walls, seconds=4.0, robot=(0.8, 0.0))["robot"].position
    assert x < 1.0
    assert y < 1.0
    assert x == pytest.approx(y, abs=0.02)


def test_bodies_above_or_flat_on_the_ground_are_not_obstacles():
    bridge, sill = (
        prop("bridge", Box((0.2, 9, 1)), at(1, 0, 2)),
        prop("sill", Box((0.2, 9, 0.04)), at(1, 0, 0)),
    )
    assert driven(floor(), robot(), bridge, sill, robot=(0.8, 0.0))["robot"].position[0] == pytest.approx(2.4)


def test_robots_do_not_run_through_each_other():
    there = driven(floor(), robot("a"), robot("b", x=3.0, yaw=pi), a=(0.8, 0.0), b=(0.8, 0.0))
    assert there["b"].position[0] - there["a"].position[0] > 0.75
