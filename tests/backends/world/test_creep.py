"""Objects that friction holds: 2.5 N on both sides with a friction of 0.5 hold 0.255 kg."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from nrp_core.findings import Code
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController
from nrp_core.scene.model import Box, Collision, Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose
from nrp_core.world import World

MOMENTS = (0.001, 0.001, 0.001, 0.0, 0.0, 0.0)
GRAVITY = 9.8


def hand() -> Model:
    """Return two fingers that slide towards each other, on a base that is fixed to the world."""
    shape = Collision("c", Box((0.1, 0.02, 0.1)), friction=0.5)
    links = [Link("base", inertial=Inertial(5.0))]
    joints = [Joint("fixed", "fixed", "world", "base")]
    for name, sign in (("left", -1.0), ("right", 1.0)):
        pose = Pose((0.0, -0.0601 * sign, 1.0))
        links.append(Link(name, pose, Inertial(0.1, inertia=MOMENTS), collisions=(shape,)))
        joints.append(Joint(name, "prismatic", "base", name, pose, (0.0, sign, 0.0), -0.1, 0.1))
    controllers = tuple(JointController(name, "effort", f"/hand/{name}", None) for name in ("left", "right"))
    return Model("hand", tuple(links), tuple(joints), controllers=controllers)


@pytest.fixture
def grasp(open_world, parts, advance) -> Callable[..., tuple[World, float]]:
    """Hold a box for some seconds; return the world, and by how much the box sank, m."""

    def hold(mass: float, seconds: float, **options: float) -> tuple[World, float]:
        box = parts.prop("box", Box((0.1, 0.1, 0.08)), Pose((0.0, 0.0, 1.0)), mass=mass, friction=0.5)
        world = open_world(hand(), box, **options)
        for finger in ("left", "right"):
            world.advertise(f"/hand/{finger}").publish(Float64(2.5))
        advance(world, 1.0)
        before = world.model_motion("box").pose.position[2]
        advance(world, seconds)
        return world, before - world.model_motion("box").pose.position[2]

    return hold


def reported(world: World) -> list[str]:
    return [each.subject for each in world.warnings if each.code is Code.NRP386]


def test_an_object_stays_in_a_grasp_that_holds_it(grasp, backend):
    options = {"impratio": 100.0} if backend.engine_name == "MuJoCo" else {}
    world, sank = grasp(0.2, 10.0, **options)
    assert abs(sank) < 0.5e-3
    assert not reported(world)


def test_an_object_that_slides_in_a_grasp_is_reported_once(grasp, backend):
    if backend.engine_name != "MuJoCo":
        pytest.skip("only MuJoCo's friction yields")
    world, sank = grasp(0.2, 3.0)
    assert sank > 5e-3
    assert reported(world) == ["box"]


def test_an_object_that_friction_does_not_hold_falls_unreported(grasp):
    """0.3 kg weigh 2.94 N, and 2.5 N of friction hold: it falls with 1.47 m/s^2."""
    world, sank = grasp(0.3, 0.1)
    assert sank > 0.5 * (GRAVITY - 2.5 / 0.3) * 0.1**2
    assert not reported(world)


def test_a_scene_of_one_file_keeps_its_ratio_unless_the_experiment_gives_one(open_world, tmp_path, backend):
    if backend.engine_name != "MuJoCo":
        pytest.skip("of MuJoCo")
    from nrp_core.scene.sdf import read_scene

    body = "<worldbody><body><freejoint/><geom size='.1'/></body></worldbody>"
    file = tmp_path / "ball.xml"
    file.write_text(f"<mujoco><option impratio='7'/>{body}</mujoco>")
    assert open_world(read_scene(file)).engine._model.opt.impratio == 7
    assert open_world(read_scene(file), impratio=3).engine._model.opt.impratio == 3
