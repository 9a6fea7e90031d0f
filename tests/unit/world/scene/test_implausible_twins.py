"""Collision shapes that differ from a visual by one slip, and others that differ on purpose."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from nrp_core import Scene
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.implausible import implausible
from nrp_core.world.scene.model import Box, Collision, Cylinder, Geometry, Link, Model, Sphere, Visual

_WALL, _UP = Box((0.1, 8.0, 1.0)), (0.0, 2.0, 0.5)
Placed = tuple[Geometry, tuple[float, float, float]]


def _said(felt: Sequence[Placed], seen: Sequence[Placed], *, static: bool = True) -> list[str]:
    collisions = tuple(Collision(f"c{n}", shape, Pose(place)) for n, (shape, place) in enumerate(felt))
    visuals = tuple(Visual(f"v{n}", shape, pose=Pose(place)) for n, (shape, place) in enumerate(seen))
    model = Model("room", (Link("walls", collisions=collisions, visuals=visuals),), static=static)
    return [sentence for _, sentence in implausible(Scene((model,)), [])]


@pytest.mark.parametrize(
    ("felt", "seen", "how"),
    [
        ((Box((100.0, 8.0, 1.0)), _UP), (_WALL, _UP), "100 8 1 and 0.1 8 1 m; is one of them in another"),
        ((Box((8.0, 0.1, 1.0)), _UP), (_WALL, _UP), "8 0.1 1 and 0.1 8 1 m, two of which are exchanged"),
        ((_WALL, _UP), (_WALL, (0.0, 2.0, -0.5)), "0 2 0.5 and 0 2 -0.5 m, which differ in a sign"),
        ((_WALL, _UP), (_WALL, (2.0, 0.0, 0.5)), "0 2 0.5 and 2 0 0.5 m, two of which are exchanged"),
        ((_WALL, _UP), (_WALL, (0.0, 2.0, 500.0)), "0 2 0.5 and 0 2 500 m; is one of them in another unit?"),
        ((Sphere(0.3), _UP), (Sphere(0.0003), _UP), "0.3 and 0.0003 m; is one of them in another unit?"),
        ((Cylinder(1.0, 0.2), _UP), (Cylinder(0.2, 1.0), _UP), "1 0.2 and 0.2 1 m, two of which are excha"),
    ],
)  # fmt: skip
def test_a_shape_that_differs_by_a_slip_from_what_is_seen_is_reported(
    felt: Placed, seen: Placed, how: str
) -> None:
    other = (Box((1.0, 1.0, 1.0)), (5.0, 5.0, 0.5))
    (sentence,) = _said([felt, other], [seen, other])
    assert sentence.startswith("the collision 'c0' of the link 'walls' of 'room' is the same ")
    assert how in sentence


@pytest.mark.parametrize(
    ("felt", "seen"),
    [
        ([(_WALL, _UP)], [(_WALL, _UP), (_WALL, (0.0, 2.0, -0.5))]),  # two alike are seen, one is felt
        ([(Box((0.2, 8.0, 1.0)), _UP)], [(_WALL, _UP)]),  # a little thicker
        ([(Box((100.0, 80.0, 1.0)), _UP)], [(_WALL, _UP)]),  # another shape
        ([(_WALL, _UP)], [(_WALL, (0.0, 2.0, 0.6)), (Sphere(1.0), _UP)]),
        ([(Sphere(0.3), _UP)], [(Sphere(0.01), _UP)]),
    ],
)
def test_a_shape_that_differs_otherwise_is_not_reported(felt: list[Placed], seen: list[Placed]) -> None:
    assert _said(felt, seen) == []


def test_the_balls_of_robots_are_compared_as_a_whole() -> None:
    said = _said([(Sphere(0.3), _UP)], [(Sphere(0.0003), _UP)], static=False)
    assert not any("the same sphere" in sentence for sentence in said)
