"""Static shapes cost little in a step, however many there are."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from nrp_world_mujoco.build import MANY_GEOMS
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.shapes import MAX_SHAPES

from nrp_core.scene.model import Box, Collision, Inertial, Link, Model, Scene, Sphere
from nrp_core.scene.rigid import Pose


def tiles(count: int) -> Model:
    """Return a floor of square tiles of 0.1 m, in a row of rows of 40."""
    tiles = tuple(
        Collision(f"tile{i}", Box((0.1, 0.1, 0.1)), Pose((i // 40 / 10, i % 40 / 10, -0.05)))
        for i in range(count)
    )
    return Model("floor", (Link("link", collisions=tiles),), static=True)


def ball(x: float, y: float) -> Model:
    sphere = Collision("c", Sphere(0.1), friction=0.5)
    inertial = Inertial(1.0, inertia=(0.004, 0.004, 0.004, 0, 0, 0))
    return Model("ball", (Link("link", inertial=inertial, collisions=(sphere,)),), pose=Pose((x, y, 0.4)))


@pytest.mark.parametrize("backend", ["pybullet"], indirect=True)
def test_in_pybullet_static_shapes_are_never_links_which_it_would_test_against_each_other(
    open_world, advance
):
    world = open_world(Scene((tiles(3 * MAX_SHAPES + 1), ball(0.0, 1.5))))
    client = world.engine._client
    assert bullet.getNumBodies(client) == 4 + 1
    bodies = [bullet.getBodyUniqueId(i, client) for i in range(5)]
    assert [bullet.getNumJoints(body, client) for body in bodies] == [0] * 5
    advance(world, 1.0)
    assert world.model_motion("ball").pose.position[2] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize("backend", ["mujoco"], indirect=True)
def test_mujoco_places_many_static_geoms_once_and_moves_the_others_as_before(open_world, advance):
    scene = Scene((tiles(MANY_GEOMS), ball(1.0, 1.5)))
    one, other = open_world(scene), open_world(scene)
    flags = other.engine._model.opt
    assert one.engine._model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP
    flags.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    for _ in range(2):
        for world in (one, other):
            advance(world, 1.5)
        state, without = one.engine._data.qpos, other.engine._data.qpos
        assert np.array_equal(state, without)
        assert state[2] == pytest.approx(0.1, abs=2e-3)
        for world in (one, other):
            world.reset(seed=1)
