"""Joints that close loops, on both engines, against the motion of a parallelogram."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from golden import Golden

from nrp_core.findings import Findings
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.capabilities import WorldCapabilities, check_scene

LENGTH, APART, CRANK_KG, COUPLER_KG, GRAVITY = 0.5, 0.3, 0.4, 1.0, 9.8
SWING = 0.1


def part(name: str, place: str, mass: float, centre: str, inertia: float) -> str:
    moments = "".join(f"<i{axis}>{inertia}</i{axis}>" for axis in ("xx", "yy", "zz"))
    inertial = f"<pose>{centre} 0 0 0.3</pose><mass>{mass}</mass><inertia>{moments}</inertia>"
    return f'<link name="{name}"><pose>{place} 0 0 0</pose><inertial>{inertial}</inertial></link>'


def turns(name: str, parent: str, child: str, place: str, kind: str = "revolute") -> str:
    """Return a joint about y at a place in the frame of the model."""
    axis = "" if kind == "ball" else "<axis><xyz>0 1 0</xyz></axis>"
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    pose = f'<pose relative_to="__model__">{place} 0 0 0</pose>'
    return f'<joint name="{name}" type="{kind}">{pose}{ends}{axis}</joint>'


def linkage(read, kind: str = "revolute") -> Model:
    """Return two cranks that hang from the world, and a rod that connects their ends.

    Only one joint is told where to start; the others close the loop.
    """
    low, crank = -LENGTH, CRANK_KG * LENGTH**2 / 12
    model = read(
        part("left", "0 0 0", CRANK_KG, f"0 0 {low / 2}", crank)
        + part("right", f"{APART} 0 0", CRANK_KG, f"0 0 {low / 2}", crank)
        + part("rod", f"0 0 {low}", COUPLER_KG, f"{APART / 2} 0 0", 0.01)
        + turns("a", "world", "left", "0 0 0")
        + turns("b", "world", "right", f"{APART} 0 0")
        + turns("c", "left", "rod", f"0 0 {low}")
        + turns("d", "right", "rod", f"{APART} 0 {low}", kind)
    )
    return replace(model, pose=Pose((1.0, 2.0, 3.0), (0.0, 0.0, 0.6, 0.8)), starts=(("a", SWING),))


@pytest.mark.parametrize("kind", ["revolute", "ball"])
def test_a_parallelogram_swings_as_one_pendulum(open_world, advance, read, kind: str, golden: Golden) -> None:
    model = linkage(read, kind)
    assert [loop.name for loop in model.loops] == ["d"]
    golden(str(model.warnings[0]))
    world = open_world(Scene((model,), gravity=(0.0, 0.0, -GRAVITY)))
    # the rod moves along a circle without turning: all of its mass is at the ends of the cranks
    inertia = 2 * CRANK_KG * LENGTH**2 / 3 + COUPLER_KG * LENGTH**2
    stiffness = (2 * CRANK_KG / 2 + COUPLER_KG) * GRAVITY * LENGTH
    period = 2 * pi * sqrt(inertia / stiffness) * (1 + SWING**2 / 16)
    for share in (0.25, 0.5, 1.0):
        advance(world, share * period)
        joints = world.joint_states(model.name)
        at = dict(zip(joints.names, joints.positions.tolist(), strict=True))
        expected = SWING * cos(2 * pi * world.now_ns / 1e9 / period)
        assert at["a"] == pytest.approx(expected, abs=0.03 * SWING)
        assert at["b"] == pytest.approx(at["a"], abs=2e-3)
        assert at["c"] == pytest.approx(-at["a"], abs=2e-3)
        ends = [world.engine.link_motion(model.name, name).pose for name in ("right", "rod")]
        here, there = (
            np.array((pose @ Pose(way)).position)
            for pose, way in zip(ends, ((0.0, 0.0, -LENGTH), (APART, 0.0, 0.0)), strict=True)
        )
        assert np.linalg.norm(here - there) < 1e-3


def test_a_piston_slides_as_its_crank_turns(open_world, advance, read) -> None:
    """The joint that slides stays, wherever the file has it; a joint that turns closes the loop."""
    masses, low, starts = {"crank": 0.5, "rod": 0.5, "piston": 2.0}, -0.3, 0.6
    long = low - LENGTH
    slide = "<parent>world</parent><child>piston</child><axis><xyz>0 0 1</xyz></axis>"
    model = read(
        part("crank", "0 0 0", masses["crank"], f"0 0 {low / 2}", 0.004)
        + part("rod", f"0 0 {low}", masses["rod"], f"0 0 {-LENGTH / 2}", 0.01)
        + part("piston", f"0 0 {long}", masses["piston"], "0 0 0", 0.01)
        + turns("a", "world", "crank", "0 0 0")
        + turns("b", "crank", "rod", f"0 0 {low}")
        + turns("c", "rod", "piston", f"0 0 {long}")
        + f'<joint name="slide" type="prismatic">{slide}</joint>'
    )
    assert ([loop.name for loop in model.loops], model.joint("slide").kind) == (["c"], "prismatic")
    model = replace(model, starts=(("a", starts),))
    world = open_world(Scene((model,), gravity=(0.0, 0.0, -GRAVITY)))
    heights, before = {"crank": low / 2, "rod": -LENGTH / 2, "piston": 0.0}, None
    angles = []
    for _ in range(5):
        advance(world, 0.1)
        joints = world.joint_states(model.name)
        at = dict(zip(joints.names, joints.positions.tolist(), strict=True))
        aside, down = -low * sin(at["a"]), -low * cos(at["a"])
        assert long + at["slide"] == pytest.approx(-down - sqrt(LENGTH**2 - aside**2), abs=1e-3)
        motions = {name: world.engine.link_motion(model.name, name) for name in masses}
        centres = {name: motion.at(Pose((0.0, 0.0, heights[name]))) for name, motion in motions.items()}
        assert centres["piston"].pose.position[:2] == pytest.approx((0.0, 0.0), abs=1e-3)
        energy = sum(
            mass * (GRAVITY * centres[name].pose.position[2] + np.dot(*[centres[name].linear] * 2) / 2)
            + inertia * np.dot(*[centres[name].angular] * 2) / 2
            for (name, mass), inertia in zip(masses.items(), (0.004, 0.01, 0.01), strict=True)
        )
        before = energy if before is None else before
        assert energy == pytest.approx(before, abs=0.1)
        angles.append(at["a"])
    assert max(angles) - min(angles) > 0.5, "it moves"


def test_a_loop_within_one_body_changes_nothing(open_world, advance, read) -> None:
    """Two fixed joints between the same links are one, as files have them."""
    held = '<joint name="{}" type="fixed"><parent>a</parent><child>b</child></joint>'
    model = read(part("a", "0 0 0", 1.0, "0 0 0", 0.1) + part("b", "1 0 0", 1.0, "0 0 0", 0.1)
                 + held.format("one") + held.format("two"))  # fmt: skip
    world = open_world(Scene((model,), gravity=(0.0, 0.0, -GRAVITY)))
    advance(world, 0.5)
    assert world.model_motion("robot").linear[2] == pytest.approx(-GRAVITY / 2, rel=1e-3)


def test_an_engine_that_leaves_loops_open_says_so(read, golden: Golden) -> None:
    warnings = Findings(())
    check_scene(Scene((linkage(read),)), WorldCapabilities(1_000_000), object(), warnings)
    (warning,) = warnings
    assert "'robot'" in str(warning)
    golden(str(warning))
