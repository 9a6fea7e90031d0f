"""A file in MJCF is, joint for joint and contact for contact, the mechanism that MuJoCo alone makes of it.

Both get the same random positions and velocities, and their masses, forces and accelerations are compared,
in shares of the largest.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from nrp_core import worlds
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene
from nrp_core.world.robot_setup import RobotSetup, set_up_robot

MOVING = ("qfrc_bias", "qfrc_passive", "qacc_smooth", "mass")
TOUCHING = ("qfrc_constraint", "qacc", "contacts")

ANIMAL = """<mujoco model="animal"><compiler angle="radian"/>
  <option timestep="0.002" density="1000" viscosity="0.1" cone="elliptic" gravity="0 0 -9.81">
    <flag refsafe="disable"/></option>
  <default><geom density="0" friction="0.4 0.01 0.002"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" friction="0.9 0.005 0.0001"/>
    <body name="trunk" pos="0 0 0.012"><joint name="root" type="free" armature="1e-7" damping="1e-6"/>
      <geom type="capsule" size="0.002" fromto="-0.01 0 0 0.01 0 0" mass="1e-6" contype="0" conaffinity="0"/>
      <body name="leg" pos="0.01 0 0">
        <joint name="yaw" axis="0 0 1" damping="1e-9" stiffness="1e-8" springref="0.2"/>
        <joint name="pitch" axis="0 1 0" damping="1e-9" frictionloss="1e-3" ref="0.3"/>
        <joint name="roll" axis="1 0 0" range="-0.1 0.1"/>
        <geom type="capsule" size="0.001" fromto="0 0 0 0 0 -0.008" mass="1e-7" contype="0" conaffinity="0"/>
        <body name="shin" pos="0 0 -0.008"><joint name="ankle" type="ball" armature="1e-12" damping="1e-10"/>
          <geom name="foot" type="box" size="0.001 0.001 0.004" pos="0 0 -0.004" mass="1e-7" condim="1"/>
        </body></body>
      <body name="balloon" pos="-0.01 0 0.003" gravcomp="1"><joint name="sway" axis="0 1 0"/>
        <geom size="0.001" pos="0 0 0.002" mass="1e-7" contype="0" conaffinity="0"/></body>
    </body>
  </worldbody>
  <tendon><fixed name="cord" limited="true" range="-0.01 0.01" solreflimit="0.002 1">
    <joint joint="yaw" coef="1"/><joint joint="pitch" coef="-0.5"/></fixed></tendon>
</mujoco>"""


def files() -> Iterator[Any]:
    """Yield the files of PyBullet's data and of Gymnasium that MuJoCo reads and that have joints."""
    own = {"pybullet_data": "mjcf", "gymnasium": "envs/mujoco/assets"}
    names = {
        "pybullet_data": ("ant", "humanoid", "inverted_pendulum", "pusher", "reacher", "striker", "thrower"),
        "gymnasium": ("ant", "half_cheetah", "hopper", "humanoid", "inverted_pendulum", "point", "reacher",
                      "swimmer", "walker2d_v5"),
    }  # fmt: skip
    for package, folder in own.items():
        found = find_spec(package)
        if found is not None and found.origin is not None:
            for name in names[package]:
                path = Path(found.origin).parent / folder / f"{name}.xml"
                yield pytest.param(path, id=f"{package}-{name}")


def paired(ours: Any, theirs: Any) -> list[tuple[int, int]]:
    """Return the joints of the file with those of the scene, which name free joints by their body."""
    kinds = mujoco.mjtJoint
    known = {}
    for joint in range(ours.njnt):
        body, _, name = ours.joint(joint).name.partition("/")
        known[body if name.endswith("/free") else name] = joint
    names = [
        theirs.body(theirs.jnt_bodyid[joint]).name or f"body_{theirs.jnt_bodyid[joint]}"
        if kinds(theirs.jnt_type[joint]) == kinds.mjJNT_FREE
        else theirs.joint(joint).name or f"joint_{joint}"
        for joint in range(theirs.njnt)
    ]
    return [(joint, known.get(name, known.get(f"{name}_joint", -1))) for joint, name in enumerate(names)]


def differences(path: Path, seed: int = 3) -> dict[str, float]:
    """Return the largest differences over some states."""
    backend, kinds = worlds().load("mujoco"), mujoco.mjtJoint
    with backend.open(read_scene(path), seed=1, options=backend.options()) as world:
        ours, here = world.engine._model, world.engine._data
        theirs = mujoco.MjModel.from_xml_path(str(path))
        there, random = mujoco.MjData(theirs), np.random.default_rng(seed)
        found = dict.fromkeys((*MOVING, *TOUCHING), 0.0)
        for _ in range(6):
            freedoms: tuple[list[int], list[int]] = ([], [])
            for one, other in paired(ours, theirs):
                at, to = int(theirs.jnt_qposadr[one]), int(ours.jnt_qposadr[other])
                dof, own = int(theirs.jnt_dofadr[one]), int(ours.jnt_dofadr[other])
                kind, zero = kinds(theirs.jnt_type[one]), theirs.qpos0
                size, length = {kinds.mjJNT_FREE: (7, 6), kinds.mjJNT_BALL: (4, 3)}.get(kind, (1, 1))
                position = zero[at : at + size] + random.uniform(-0.2, 0.2, size)
                if size == 7:
                    position[:3] = zero[at : at + 3] * random.uniform(0.3, 1.1)
                if size > 1:
                    position[-4:] /= np.linalg.norm(position[-4:])
                there.qpos[at : at + size] = position
                here.qpos[to : to + size] = position - (zero[at] if size == 1 else 0.0)
                velocity = random.normal(size=length)
                there.qvel[dof : dof + length] = here.qvel[own : own + length] = velocity
                freedoms[0].extend(range(dof, dof + length))
                freedoms[1].extend(range(own, own + length))
            mujoco.mj_forward(theirs, there)
            mujoco.mj_forward(ours, here)
            for name, difference in compared((theirs, there, freedoms[0]), (ours, here, freedoms[1])):
                found[name] = max(found[name], difference)
    return found


def compared(one: Any, other: Any) -> Iterator[tuple[str, float]]:
    def values(name: str, model: Any, data: Any, dofs: list[int]) -> Any:
        if name == "contacts":
            return np.array([data.ncon, data.nefc], float)
        if name != "mass":
            return getattr(data, name)[dofs]
        matrix = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, matrix)
        return matrix[np.ix_(dofs, dofs)]

    for name in (*MOVING, *TOUCHING):
        theirs, ours = values(name, *one), values(name, *other)
        largest = float(abs(theirs).max()) or 1.0
        yield name, float(abs(ours - theirs).max()) / largest


@pytest.mark.parametrize("path", list(files()))
def test_a_file_is_the_mechanism_that_mujoco_alone_makes_of_it(path):
    found = differences(path)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-11)


CLUSTER = """<mujoco><option gravity="0 0 0">{flag}</option><worldbody>
  <body name="trunk"><freejoint/><geom name="trunk" size="0.1" mass="1"/>
    <body name="arm" pos="0.15 0 0"><joint name="a" axis="0 0 1"/><joint name="b" axis="0 1 0"/>
      <geom name="arm" size="0.1" mass="1"/>
      <body name="hand" pos="0 0.04 0"><joint name="c" axis="0 1 0"/><geom name="hand" size="0.1" mass="1"/>
        <body name="ring"><geom name="ring" size="0.1" mass="1"/></body></body></body>
    <body name="tail" pos="-0.15 0 0"><joint name="d" axis="0 0 1"/><joint name="e" axis="0 1 0"/>
      <geom name="tail" size="0.1" mass="1"/>
      <body name="tip" pos="0 0.04 0"><joint name="f" axis="0 1 0"/><geom name="tip" size="0.1" mass="1"/>
    </body></body></body></worldbody>
  <contact><exclude body1="trunk" body2="tip"/><exclude body1="hand" body2="ring"/></contact></mujoco>"""


def touching(
    folder: Path, flag: str = "", *, fixed: bool | None = None
) -> tuple[set[frozenset[str]], set[frozenset[str]]]:
    """Return the shapes of the cluster that touch here, and in MuJoCo alone."""
    (folder / "cluster.xml").write_text(CLUSTER.format(flag=flag))
    backend = worlds().load("mujoco")
    theirs = mujoco.MjModel.from_xml_path(str(folder / "cluster.xml"))
    (read,) = read_scene(folder / "cluster.xml").models
    scene = Scene((set_up_robot(read, RobotSetup(fixed)),), gravity=(0.0, 0.0, 0.0))
    with backend.open(scene, seed=1, options=backend.options()) as world:
        found = []
        for model in (world.engine._model, theirs):
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
            names = [[model.geom(n).name.rpartition("/")[2] for n in each.geom] for each in data.contact]
            found.append(set(map(frozenset, names)))
    return found[0], found[1]


@pytest.mark.parametrize("flag", ["", '<flag filterparent="disable"/>'])
def test_shapes_of_a_file_touch_each_other_but_neighbours_and_excluded_ones(tmp_path, flag):
    ours, theirs = touching(tmp_path, flag)
    assert frozenset({"trunk", "hand"}) in theirs
    assert (frozenset({"trunk", "arm"}) in theirs) == bool(flag)
    assert ours == theirs


def test_the_base_of_a_robot_that_an_experiment_fixes_touches_no_neighbour_either(tmp_path):
    """MuJoCo has no such filter for what is fixed to the world, and the file has a free base."""
    ours, theirs = touching(tmp_path, fixed=True)
    assert ours == theirs


@pytest.mark.parametrize(
    ("place", "value"), [("build.touches_itself", lambda _: False), ("build.neighbours", lambda _: [])]
)
def test_other_neighbours_are_distinguished(tmp_path, monkeypatch, place, value):
    monkeypatch.setattr(f"nrp_world_mujoco.{place}", value)
    ours, theirs = touching(tmp_path)
    assert ours != theirs


def animal(folder: Path) -> dict[str, float]:
    (folder / "animal.xml").write_text(ANIMAL)
    return differences(folder / "animal.xml")


def test_an_animal_of_a_milligram_is_too(tmp_path):
    found = animal(tmp_path)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-9)


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        ("build.let_weigh_nothing", lambda *_: None, "mass"),
        ("mjcf_native._RUBS", (), "qacc"),
        ("mjcf_native._RUBBING", (), "qacc"),
        ("mjcf_native._OF_FREE_DOF", (), "qacc_smooth"),
        ("mjcf_native._FLAGS", (), "qacc"),
        ("mjcf_native._TENDON", {}, "qacc"),
    ],
)
def test_another_mechanism_is_distinguished(tmp_path, monkeypatch, place, value, told):
    monkeypatch.setattr(f"nrp_world_mujoco.{place}", value)
    assert animal(tmp_path)[told] > 1e-6


WALKER = """<mujoco><compiler angle="radian"/><option timestep="0.0025"/>
  <asset>
    <hfield name="hills" size="2 2 0.05 0.01" nrow="3" ncol="4" elevation="0 1 0 .5 1 .2 0 1 .3 0 1 0"/>
  </asset>
  <worldbody><geom type="hfield" hfield="hills"/>
    <body name="trunk" pos="0 0 0.45"><freejoint/><geom size="0.1" mass="1"/>
      <body name="thigh" pos="0 0 -0.1">
        <joint name="yaw" axis="0 0 1" damping=".1"/>
        <joint name="pitch" axis="0 1 0" damping=".1" range="0.1 0.9"/>
        <geom type="capsule" fromto="0 0 0 0 0 -.15" size=".03" mass=".2"/>
        <body name="shank" pos="0 0 -0.15" quat="1 .2 0 0"><geom size="0.04" mass="0.1" pos="0 0 -.05"/>
          <body name="foot" pos="0 0 -.05"><joint name="ankle" axis="0 1 0" damping=".02"/>
            <geom name="sole" size=".05" pos=".02 0 -.05" mass=".1"/>
            <body name="toe" pos=".1 0 -.05"><geom size=".03" mass=".05"/></body></body></body></body>
    </body></worldbody>
  <actuator><position joint="pitch" kp="8"/><velocity joint="ankle" kv="0.02"/></actuator></mujoco>"""


def test_a_scene_of_one_file_moves_as_in_mujoco_alone(tmp_path):
    """Parts that are fixed to others touch hills, and a joint starts beyond its limits."""
    (tmp_path / "walker.xml").write_text(WALKER)
    theirs, backend = mujoco.MjModel.from_xml_string(WALKER), worlds().load("mujoco")
    there = mujoco.MjData(theirs)
    with backend.open(read_scene(tmp_path / "walker.xml"), seed=1, options=backend.options()) as world:
        assert world.engine.step_ns == 2_500_000
        mujoco.mj_step(theirs, there, 240)
        world.run_until(240 * world.engine.step_ns)
        assert there.ncon
        np.testing.assert_allclose(world.engine._data.qpos, there.qpos, rtol=0, atol=1e-10)


def test_a_time_step_of_a_file_that_does_not_divide_that_of_the_loop_is_the_next_smaller_one(tmp_path):
    (tmp_path / "walker.xml").write_text(WALKER)
    backend, scene = worlds().load("mujoco"), read_scene(tmp_path / "walker.xml")
    for period_ms, wanted_ms in ((20, 2.5), (2.5, 2.5), (2, 2), (11, 2.2)):
        options, message = backend.fit(backend.options(), scene, round(period_ms * 1e6))
        assert options.timestep == round(wanted_ms * 1e6)
        assert bool(message) == (wanted_ms != 2.5)
    options, message = backend.fit(backend.options(), scene, 8_333_333)  # only tiny steps divide that
    assert (options.timestep, message) == (2_500_000, "")
    given = backend.options.model_validate({"timestep": "1 ms"})
    assert backend.fit(given, scene, 20_000_000) == (given, "")
