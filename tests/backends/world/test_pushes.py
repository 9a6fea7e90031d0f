"""Pushes on links that are fixed to each other, on both engines, against closed forms."""

from __future__ import annotations

from math import cos

import pytest

from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Vector3, Wrench
from nrp_core.scene import rigid
from nrp_core.scene.model import Inertial, Joint, Link, Model, Scene
from nrp_core.scene.rigid import Pose

INERTIA = 0.2 + 2 * 0.25  # of the pair about its centre of mass


@pytest.fixture
def world(open_world):
    """Two balls of 1 kg, 1 m apart on a stick, without gravity."""
    mass = Inertial(1.0, inertia=(0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    links = Link("near", inertial=mass), Link("far", Pose((1.0, 0.0, 0.0)), mass)
    pair = Model("pair", links, (Joint("stick", "fixed", "near", "far"),))
    return open_world(Scene((pair,), gravity=(0.0, 0.0, 0.0)))


def push(world, link: str, x: float, y: float) -> None:
    wrench = Wrench(Vector3(x, y, 0.0), Vector3())
    assert world.call(
        "/gazebo/apply_body_wrench", body_name=f"pair::{link}", wrench=wrench, duration=Duration(-1)
    ).success


def test_pushes_on_both_links_of_a_body_add_up(world, advance):
    push(world, "near", 1.0, 0.0)
    push(world, "far", 1.0, 0.0)
    advance(world, 1.0)
    motion = world.model_motion("pair")
    assert motion.linear == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
    assert motion.angular == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    world.call("/gazebo/clear_body_wrenches", "pair::far")
    advance(world, 1.0)
    assert world.model_motion("pair").linear[0] == pytest.approx(1.5, abs=0.05)


def test_a_reset_ends_the_wrenches_of_all_owners(world, advance):
    world.engine.set_wrench("pair", "near", rigid.Wrench((1.0, 0.0, 0.0)), "wind")
    world.reset()
    push(world, "far", 1.0, 0.0)
    advance(world, 1.0)
    assert world.model_motion("pair").linear[0] == pytest.approx(0.5, abs=0.05)


def test_a_push_that_lasts_no_time_is_refused(world):
    wrench = Wrench(Vector3(1.0, 0.0, 0.0), Vector3())
    answer = world.call("/gazebo/apply_body_wrench", body_name="pair::far", wrench=wrench)
    assert not answer.success
    assert "a force on 'far' that lasts 0 s has no effect: give it a 'duration'" in answer.status_message


def test_a_push_beside_the_centre_turns_with_the_body_also_from_a_snapshot_on(world, advance):
    push(world, "far", 0.0, 1.0)
    angle, rate, step_s = 0.0, 0.0, 1e-4
    for _ in range(25000):
        rate += step_s * 0.5 * cos(angle) / INERTIA
        angle += step_s * rate
    advance(world, 1.5)
    middle = world.snapshot()
    advance(world, 1.0)
    end = world.model_motion("pair")
    assert end.pose.yaw == pytest.approx(angle, abs=5e-3)
    assert end.angular[2] == pytest.approx(rate, abs=2e-3)
    world.restore(middle)
    advance(world, 1.0)
    assert world.model_motion("pair") == end
