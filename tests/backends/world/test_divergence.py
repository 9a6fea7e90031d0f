"""A world that leaves what is possible is reported, although all of its numbers are finite."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import DivergedError
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.scene.rigid import ModelMotion
from nrp_core.scene.sdf import read_scene
from nrp_core.world import World
from nrp_core.world.backends import worlds

N = 12
_MS = 1_000_000
SOFTER = "solreflimit='-3000 -20' solimplimit='.5 .9 .1 .4 3' margin='.01' "
"""Properties of limits away from their defaults."""
MOTOR = "armature='0.0003' "
"""An inertia that is some ten times that of a link."""


def neck(mass: float = 0.02, force: float = 500.0) -> str:
    """Return twelve light links in a row, with two strong straight muscles at each joint."""
    bodies = (
        "".join(
            f"<body name='link{i}' pos='{0.05 * (i > 0)} 0 0'>"
            f"<joint name='joint{i}' axis='0 1 0' range='-60 60' limited='true' damping='0.01'/>"
            f"<geom type='capsule' fromto='0 0 0 0.05 0 0' size='0.01' mass='{mass}'"
            " contype='0' conaffinity='0'/>"
            + "".join(
                f"<site name='in{i}{z}' pos='0.02 0 {z}'/><site name='out{i + 1}{z}' pos='0.03 0 {z}'/>"
                for z in (0.015, -0.015)
            )
            for i in range(N)
        )
        + "</body>" * N
    )
    pairs = [(i, z) for i in range(N) for z in (0.015, -0.015)]
    tendons = "".join(
        f"<spatial name='tendon{i}{z}'><site site='out{i}{z}'/><site site='in{i}{z}'/></spatial>"
        for i, z in pairs
    )
    muscles = "".join(
        f"<muscle name='muscle{i}{z}' tendon='tendon{i}{z}' lengthrange='0.02 0.06' force='{force}' "
        "ctrllimited='true' ctrlrange='0 1'/>"
        for i, z in pairs
    )
    return (
        "<mujoco model='neck'><worldbody><body name='base' pos='0 0 1'>"
        "<geom size='0.01' mass='1' contype='0' conaffinity='0'/>"
        "<site name='out00.015' pos='-0.02 0 0.015'/><site name='out0-0.015' pos='-0.02 0 -0.015'/>"
        f"{bodies}</body></worldbody><tendon>{tendons}</tendon><actuator>{muscles}</actuator></mujoco>"
    )


def open_world(backend: str, file: Path) -> World:
    chosen = worlds().load(backend)
    return chosen.open(read_scene(file), seed=1, options=chosen.options())


def excite(world: World) -> None:
    """Give the muscles random commands for a second."""
    command = world.advertise("/base/muscles/cmd")
    for k, row in enumerate(np.random.default_rng(5).uniform(0.0, 1.0, (100, 2 * N))):
        command.publish(Float64MultiArray(data=row))
        world.run_until((k + 1) * 10 * _MS)


def test_muscles_that_throw_joints_out_of_their_limits_are_a_divergence(
    tmp_path: Path, golden: Golden
) -> None:
    file = tmp_path / "neck.xml"
    file.write_text(neck(mass=0.001, force=1e5))
    with open_world("pybullet", file) as world, golden.raises(DivergedError, match="'base'"):
        excite(world)
    file.write_text(neck())
    for engine in ("mujoco", "pybullet"):
        with open_world(engine, file) as world:
            excite(world)  # its joints stretch their limits, in MuJoCo alone by 1.5 rad
            assert np.abs(world.joint_states("base").positions).max() < 3.0


@pytest.mark.parametrize(
    "limits", ["", "range='-5 5' limited='true' ", f"range='-5 5' {SOFTER}", f"range='-5 5' {MOTOR}"]
)
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_light_links_with_strong_muscles_move_as_in_mujoco_alone(
    tmp_path: Path, engine: str, limits: str
) -> None:
    text = neck(force=200.0).replace("range='-60 60' limited='true' ", limits)
    file = tmp_path / "neck.xml"
    file.write_text(text.replace("<worldbody>", "<option integrator='implicitfast'/><worldbody>"))
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    with open_world(engine, file) as world:
        assert not [each for each in world.warnings if each.subject == "armature"]
        command = world.advertise("/base/muscles/cmd")
        for k, row in enumerate(np.random.default_rng(5).uniform(0.0, 1.0, (20, 2 * N))):
            data.ctrl[:] = row
            mujoco.mj_step(model, data, 5)
            command.publish(Float64MultiArray(data=row))
            world.run_until((k + 1) * 10 * _MS)
            np.testing.assert_allclose(world.joint_states("base").positions, data.qpos, atol=1e-6)


@pytest.mark.parametrize("backend", ["mujoco", "pybullet"])
@pytest.mark.parametrize("spin", [False, True])
def test_a_free_object_that_cannot_move_so_fast_is_a_divergence(
    tmp_path: Path, backend: str, spin: bool
) -> None:
    file = tmp_path / "ball.sdf"
    file.write_text(
        "<sdf version='1.9'><model name='ball'><link name='ball'>"
        "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
        "<collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>"
        "</link></model></sdf>"
    )
    fast = (2e6, 0.0, 0.0)
    with open_world(backend, file) as world:
        world.run_until(2 * _MS)
        pose = world.engine.model_motion("ball").pose
        world.engine.place(
            "ball", ModelMotion(pose, angular=fast) if spin else ModelMotion(pose, linear=fast)
        )
        with pytest.raises(DivergedError):
            world.run_until(4 * _MS)
