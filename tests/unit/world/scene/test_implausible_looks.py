"""Visuals that do not show their body are reported, and ordinary ones are not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from nrp_core.world.rigid import Pose
from nrp_core.world.scene.implausible import implausible
from nrp_core.world.scene.implausible_looks import of_looks
from nrp_core.world.scene.model import Box, Collision, Link, Model, Rgba, Scene, Visual

_SIZE = Box((0.4, 0.2, 1.0))


def thing(*visuals: Visual) -> Link:
    return Link("link", visuals=visuals, collisions=(Collision("hull", _SIZE),))


def said(*visuals: Visual) -> list[str]:
    """Return the sentences about a thing of a room with these visuals."""
    scene = Scene((Model("thing", (thing(*visuals),), static=True),))
    return [sentence for _, sentence in implausible(scene, ())]


def look(rgba: Rgba = (0.2, 0.4, 1.0, 1.0), x: float = 0.0, size: Box = _SIZE, name: str = "look") -> Visual:
    return Visual(name, size, Pose((x, 0.0, 0.0)), rgba)


@pytest.mark.parametrize("rgba", [(0.0, 128.0, 255.0, 1.0), (3.0, 0.0, 0.0, 1.0)])
def test_a_colour_of_bytes_is_reported(rgba: Rgba) -> None:
    (sentence,) = said(look(rgba), look(rgba, name="more"))
    assert "the colour of the visual 'look' of 'thing/link' is " in sentence
    assert "is it meant in 0 to 255?" in sentence


def test_a_thing_that_nobody_sees_is_reported() -> None:
    hidden = look((1.0, 1.0, 1.0, 0.0))
    assert said(hidden) == ["nothing of 'thing' is seen: the opacity of each of its visuals is 0"]
    assert said(hidden, replace(look(), name="seen")) == []
    assert said() == []


@pytest.mark.parametrize(
    ("x", "size", "is_reported"),
    [
        (0.0, _SIZE, False),
        (1.0, _SIZE, False),  # less far away than it is large
        (10.0, _SIZE, True),
        (0.0, Box((0.04, 0.02, 0.1)), False),  # is inside
        (10.0, Box((30.0, 0.2, 1.0)), False),
    ],
)
def test_a_link_that_is_seen_elsewhere_than_it_is_felt_is_reported(
    x: float, size: Box, is_reported: bool
) -> None:
    found = said(look(x=x, size=size))
    assert ["is seen 9.6 m away from its collision shapes" in one for one in found] == [True] * is_reported


@pytest.mark.parametrize(
    ("times", "static", "is_reported"),
    [(1000.0, True, True), (0.001, True, True), (20.0, True, False), (1000.0, False, False)],
)
def test_a_thing_that_is_seen_in_another_unit_than_it_is_felt_is_reported(
    times: float, static: bool, is_reported: bool
) -> None:
    x, y, z = _SIZE.size
    found = of_looks(
        Model("thing", (thing(look(size=Box((x * times, y * times, z * times)))),), static=static)
    )
    words = "the visuals of the link 'link' of 'thing' are "
    assert [one.startswith(words) for one in found] == [True] * is_reported


def test_a_wide_floor_with_a_small_collision_is_not_reported() -> None:
    assert said(look(size=Box((80.0, 0.2, 1.0)))) == []


def test_an_ordinary_thing_is_not_reported() -> None:
    assert said(look((1.2, 1.0, 0.0, 1.0))) == []
