"""``<velocity_decay>``: links lose a share of their velocity in each millisecond."""

from __future__ import annotations

from math import exp
from pathlib import Path

import pytest
from jointed import axis, joint, link, push, read, told, weightless

from nrp_core.findings import Code
from nrp_core.messages.base import Duration
from nrp_core.scene.sdf import read_model

MASS, LEVER = 2.0, 0.3


def decaying(linear: float, angular: float, *, com: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> str:
    whole = link("bob", MASS, (0.01, 0.02, 0.025), com)
    decay = f"<velocity_decay><linear>{linear}</linear><angular>{angular}</angular></velocity_decay>"
    return whole.replace("</link>", f"{decay}</link>")


def test_a_free_body_keeps_its_share_of_each_millisecond(open_world, tmp_path, advance):
    """Its centre of mass is beside its frame; 0.6 m/s and 1 rad/s of what a push gave it."""
    world = open_world(weightless(read(tmp_path, decaying(0.002, 0.004, com=(LEVER, 0.0, 0.0)))))
    push(
        world,
        "bob",
        torque=(0.0, 0.0, 0.025 / 0.002),
        force=(0.0, 0.6 * MASS / 0.002, 0.0),
        lasts_ns=2_000_000,
    )
    advance(world, 0.1)
    before = world.link_motion("robot", "bob")
    advance(world, 0.2)
    after = world.link_motion("robot", "bob")
    assert after.angular[2] / before.angular[2] == pytest.approx(0.996**200, rel=1e-3)
    speeds = []
    for motion in (before, after):
        x, y, _ = motion.pose.rotate((LEVER, 0.0, 0.0))
        wz = motion.angular[2]
        speeds.append((motion.linear[0] - wz * y, motion.linear[1] + wz * x))
    assert speeds[1] == pytest.approx([0.998**200 * v for v in speeds[0]], rel=1e-3, abs=1e-4)
    assert speeds[0][1] == pytest.approx(0.6 * 0.998**99, rel=5e-3)


def test_a_body_on_a_hinge_loses_what_the_decay_of_both_motions_takes(open_world, tmp_path, advance):
    """About the hinge its inertia has the part of the mass, and its own."""
    hinge = joint("revolute", axis("0 0 1"))
    world = open_world(weightless(read(tmp_path, decaying(0.002, 0.004, com=(LEVER, 0.0, 0.0)) + hinge)))
    world.call("/gazebo/apply_joint_effort", "robot::j", 1.0, duration=Duration(0, 20_000_000))
    advance(world, 0.02)
    before = told(world)[1]["j"]
    advance(world, 0.2)
    orbit, own = MASS * LEVER**2, 0.025
    rate = (2.002 * orbit + 4.008 * own) / (orbit + own)
    assert told(world)[1]["j"] / before == pytest.approx(exp(-0.2 * rate), rel=2e-3)


def test_a_joint_carries_nothing_along_its_axis_where_a_body_decays(open_world, tmp_path, advance):
    slide = joint("prismatic", axis("1 0 0"))
    world = open_world(weightless(read(tmp_path, decaying(0.002, 0.0) + slide)))
    world.call("/gazebo/apply_joint_effort", "robot::j", 10.0, duration=Duration(0, 100_000_000))
    advance(world, 0.2)
    assert told(world)[1]["j"] > 0.2  # so that the force of the decay is above 0.8 N
    assert world.engine.joint_wrench("robot", "j").force == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_no_decay_is_too_strong_for_the_step(open_world, tmp_path, advance):
    world = open_world(weightless(read(tmp_path, decaying(0.99, 0.99, com=(LEVER, 0.0, 0.0)))))
    push(world, "bob", torque=(0.1, 0.2, 0.3), force=(1.0, 2.0, 3.0))
    advance(world, 0.5)
    motion = world.link_motion("robot", "bob")
    assert max(map(abs, (*motion.linear, *motion.angular))) < 0.1


@pytest.mark.parametrize("share", ["1", "25.2", "-0.1"])
def test_a_share_that_no_velocity_can_lose_is_ignored_as_in_gazebo(tmp_path: Path, share: str) -> None:
    file = tmp_path / "robot.sdf"
    decay = f"<velocity_decay><linear>{share}</linear><angular>0.1</angular></velocity_decay>"
    links = "".join(f'<link name="{name}">{decay}</link>' for name in "ab")
    file.write_text(f'<sdf version="1.9"><model name="m">{links}</model></sdf>')
    model = read_model(file)
    assert [each.decay for each in model.links] == [(0.0, 0.0)] * 2
    (finding,) = (each for each in model.warnings if each.subject == "velocity_decay")
    assert (finding.code, finding.count) == (Code.NRP383, 2)


def test_a_damping_factor_of_a_urdf_is_a_decay(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    factor = '<gazebo reference="l"><dampingFactor>0.01</dampingFactor></gazebo>'
    file.write_text(f'<robot name="r"><link name="l"/>{factor}</robot>')
    assert read_model(file).links[0].decay == pytest.approx((10.05, 10.05), abs=1e-3)
