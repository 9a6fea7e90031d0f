"""Two joints that are led by their mean and their difference, as two eyes are."""

from __future__ import annotations

from dataclasses import replace

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController, PairController, Pid
from nrp_core.scene.model import Inertial, Joint, Link, Model, Scene

EYES = ("left", "right")
GAINS = Pid(1.0, 0.0, 0.05)
numbers = st.floats(-3, 3)


def pair(of: str, kind: str = "position", gains: Pid | None = GAINS) -> PairController:
    name = {"mean": "version", "difference": "vergence"}[of]
    return PairController(name, of, EYES, kind, f"/{name}/{kind}", gains)


def head(*pairs: PairController, joints: tuple[str, str] = EYES) -> Model:
    eye = Inertial(0.05, inertia=(1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0))
    return Model(
        "head",
        tuple(Link(f"{name}_eye", inertial=eye) for name in joints),
        tuple(
            Joint(name, "revolute", "world", f"{name}_eye", damping=0.01, lower=-1.0, upper=1.0)
            for name in joints
        ),
        controllers=(JointController("left", "position", "/left", GAINS, 0.3),),
        joint_states_topic="/joints",
        pair_controllers=pairs,
    )


@given(numbers, numbers, numbers)
def test_one_of_mean_and_difference_changes_and_the_other_stays(a: float, b: float, value: float) -> None:
    mean, difference = pair("mean"), pair("difference")
    for changed, kept in ((mean, difference), (difference, mean)):
        after = changed.split(value, a, b)
        assert changed.value(*after) == pytest.approx(value, abs=1e-9)
        assert kept.value(*after) == pytest.approx(kept.value(a, b), abs=1e-9)


def test_two_eyes_follow_a_version_and_a_vergence_sent_in_one_step(open_world, advance):
    world = open_world(head(pair("mean"), pair("difference")))
    for topic, value in (("/version/position", 0.2), ("/vergence/position", 0.1)):
        world.advertise(topic).publish(Float64(value))
    advance(world, 2.0)
    assert world.joint_states("head").positions == pytest.approx([0.25, 0.15], abs=1e-3)
    message = world.subscribe("/joints").latest.message
    assert message.name == ["left", "right", "version", "vergence"]
    assert message.position == pytest.approx([0.25, 0.15, 0.2, 0.1], abs=1e-3)
    assert message.effort[2:] == pytest.approx([0.0, 0.0])


def test_a_pair_leaves_a_joint_to_its_own_command(open_world, advance):
    world = open_world(head(pair("mean")))
    world.advertise("/version/position").publish(Float64(0.2))
    advance(world, 0.5)
    world.advertise("/left").publish(Float64(-0.4))
    advance(world, 2.0)
    left, right = world.joint_states("head").positions
    # left was held at 0.3 and right stood at 0: their difference stayed, so right went to 0.05
    assert (left, right) == pytest.approx((-0.4, 0.05), abs=2e-3)


def test_a_version_of_velocities_turns_both_eyes_alike(open_world, advance):
    world = open_world(head(pair("mean", "velocity", Pid(1.0))))
    world.advertise("/version/velocity").publish(Float64(0.2))
    advance(world, 1.0)
    assert world.joint_states("head").velocities == pytest.approx([0.2, 0.2], rel=0.02)


def test_a_world_with_a_pair_goes_back_and_repeats(open_world, advance):
    world = open_world(head(pair("mean"), pair("difference")))
    world.advertise("/version/position").publish(Float64(0.3))
    advance(world, 0.2)
    saved = world.snapshot()
    advance(world, 0.4)
    there = world.joint_states("head").positions
    world.restore(saved)
    advance(world, 0.4)
    assert world.joint_states("head").positions.tolist() == there.tolist()


def test_a_pair_with_a_missing_joint_is_refused(golden: Golden):
    with golden.raises(SceneError, match="'version'.*'head'"):
        Scene((replace(head(), pair_controllers=(replace(pair("mean"), joints=("lft", "right")),)),))
