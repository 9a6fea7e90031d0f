"""The friction of a contact is the smaller of two coefficients, on both engines."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

import pytest
from nrp_world_pybullet.shapes import friction_factors

from nrp_core.findings import Findings
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Collision, Inertial, Link, Model, Scene
from nrp_core.scene.rigid import Pose

SLOPE = 0.35  # rad


def _block(name: str, mu: float, y: float) -> Model:
    inertial = Inertial(1.0, inertia=(0.01, 0.01, 0.01, 0.0, 0.0, 0.0))
    shape = Collision("c", Box((0.4, 0.4, 0.1)), friction=mu)
    return Model(name, (Link("l", inertial=inertial, collisions=(shape,)),), pose=Pose((0.0, y, 0.05)))


@pytest.mark.parametrize(
    ("block", "ground"), [(0.2, 0.5), (0.5, 0.2), (0.2, 0.2), (0.2, 1.0), (1.0, 0.2), (0.2, 10.0), (0.2, 0.0)]
)
def test_a_block_slides_as_the_smaller_coefficient_says(open_world, advance, block, ground):
    floor = Link("l", collisions=(Collision("c", Box((20, 20, 1)), Pose((0, 0, -0.5)), ground),))
    gravity = (9.81 * sin(SLOPE), 0.0, -9.81 * cos(SLOPE))
    models = (Model("floor", (floor,), static=True), _block("block", block, 0.0))
    world = open_world(Scene(models, gravity=gravity))
    advance(world, 1.0)
    expected = 9.81 * (sin(SLOPE) - min(block, ground) * cos(SLOPE)) * 1.0
    assert world.model_motion("block").linear[0] == pytest.approx(expected, rel=0.02)


def test_blocks_of_other_frictions_slide_on_one_ground(open_world, advance):
    floor = Link("l", collisions=(Collision("c", Box((20, 20, 1)), Pose((0, 0, -0.5)), 0.8),))
    gravity = (9.81 * sin(SLOPE), 0.0, -9.81 * cos(SLOPE))
    blocks = (_block("a", 0.1, -1.0), _block("b", 0.2, 0.0), _block("c", 0.3, 1.0))
    world = open_world(Scene((Model("floor", (floor,), static=True), *blocks), gravity=gravity))
    advance(world, 1.0)
    for name, mu in (("a", 0.1), ("b", 0.2), ("c", 0.3)):
        expected = 9.81 * (sin(SLOPE) - mu * cos(SLOPE))
        assert world.model_motion(name).linear[0] == pytest.approx(expected, rel=0.02)


def test_friction_that_pybullet_does_not_support_is_a_finding():
    def found(*frictions: tuple[float, bool]) -> list[str | None]:
        models = [replace(_block(f"m{i}", mu, 0.0), static=still) for i, (mu, still) in enumerate(frictions)]
        scene, warnings = Scene(tuple(models)), Findings()
        factors = friction_factors(scene, {each.name: bodies_of(each) for each in models}, warnings)
        assert set(factors) == {mu for mu, _ in frictions}
        return [each.subject for each in warnings]

    assert found((0.5, True), (0.2, False)) == []
    assert found((0.8, True), (0.1, False), (1.0, False)) == []
    assert found((0.5, True), (0.3, True), (0.8, False)) == []
    assert found((0.5, True), (0.2, False), (1.0, False)) == []
    assert found((0.5, True), (0.3, True), (0.2, False), (1.0, False)) == ["friction"]
