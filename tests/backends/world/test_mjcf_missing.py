"""An MJCF robot whose meshes or images are not there opens with simple ones, as one in URDF does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.sdf import read_scene
from nrp_core.world.backends import worlds

pytest.importorskip("nrp_world_mujoco")

ROBOT = """<mujoco><compiler meshdir="assets" texturedir="images"/>
<asset><mesh name="shell" file="shell.stl" scale="0.001 0.001 0.001"/>
<texture name="paint" type="2d" file="paint.png"/><material name="painted" texture="paint"/></asset>
<worldbody><body name="robot"><freejoint/><inertial pos="0 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>
<geom type="mesh" mesh="shell" material="painted"/></body></worldbody></mujoco>"""

CORNERS = np.array([
    [[0, 0, 0], [90, 0, 0], [0, 90, 0]], [[0, 0, 0], [0, 90, 0], [0, 0, 90]],
    [[0, 0, 0], [0, 0, 90], [90, 0, 0]], [[90, 0, 0], [0, 0, 90], [0, 90, 0]],
], float)  # fmt: skip
"""A tetrahedron."""


def told(folder: Path, engine: str = "mujoco") -> list[tuple[Code, str]]:
    (folder / "robot.xml").write_text(ROBOT)
    scene, backend = read_scene(folder / "robot.xml"), worlds().load(engine)
    with backend.open(scene, seed=1, options=backend.options()) as world:
        world.run_until(20_000_000)
    (robot,) = scene.models
    assert robot.links[0].inertial is not None
    assert robot.links[0].inertial.mass == 2.0
    return [(each.code, str(each.subject)) for each in scene.warnings if "is not there" in each.message]


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_missing_files_are_replaced_and_reported(tmp_path: Path, engine: str) -> None:
    pytest.importorskip(engine)
    assert told(tmp_path, engine) == [(Code.NRP258, "shell.stl"), (Code.NRP258, "paint.png")]


def test_files_that_are_there_are_used(tmp_path: Path) -> None:
    (tmp_path / "assets").mkdir()
    write_stl(tmp_path / "assets" / "shell.stl", CORNERS)
    assert told(tmp_path) == [(Code.NRP258, "paint.png")]


ATTACHED = """<mujoco><compiler meshdir="assets"/><asset><mesh name="shell" file="shell.stl"/></asset>
<worldbody><body name="b"><geom type="mesh" mesh="shell" mass="1"/></body></worldbody></mujoco>"""
ATTACHING = """<mujoco><asset><model name="part" file="part/part.xml"/></asset><worldbody><body name="robot">
<freejoint/><inertial pos="0 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>
<frame><attach model="part" body="b" prefix="p_"/></frame></body></worldbody></mujoco>"""


def test_files_of_an_attached_model_are_beside_that_model(tmp_path: Path) -> None:
    (tmp_path / "part" / "assets").mkdir(parents=True)
    (tmp_path / "part" / "part.xml").write_text(ATTACHED)
    (tmp_path / "robot.xml").write_text(ATTACHING)
    write_stl(tmp_path / "part" / "assets" / "shell.stl", CORNERS)
    assert read_scene(tmp_path / "robot.xml").warnings == ()


def test_a_mesh_of_an_attached_model_touches_as_in_mujoco(tmp_path: Path) -> None:
    """MuJoCo's hull of it depends on its corners, so they have to be those of the file."""
    stone = """<mujoco><compiler meshdir="assets"/><asset><mesh name="stone" file="stone.stl"
      scale="0.2 0.1 0.1" refpos="0.1 0 0.05" refquat="0.8 0 0.6 0"/></asset>
      <worldbody><body name="b"><freejoint/><geom type="mesh" mesh="stone"/></body></worldbody></mujoco>"""
    room = """<mujoco><asset><model name="part" file="part/part.xml"/></asset><worldbody>
      <geom type="plane" size="1 1 1" quat="1 0.02 0.05 0"/>
      <frame pos="0 0 0.1"><attach model="part" body="b" prefix="p_"/></frame></worldbody></mujoco>"""
    (tmp_path / "part" / "assets").mkdir(parents=True)
    (tmp_path / "part" / "part.xml").write_text(stone)
    (tmp_path / "room.xml").write_text(room)
    corners = np.random.default_rng(1).normal(size=(80, 3, 3))
    write_stl(
        tmp_path / "part" / "assets" / "stone.stl", corners / np.linalg.norm(corners, axis=2)[..., None]
    )
    alone = mujoco.MjModel.from_xml_path(str(tmp_path / "room.xml"))
    backend = worlds().load("mujoco")
    with backend.open(read_scene(tmp_path / "room.xml"), seed=1, options=backend.options()) as world:
        there, here = (_touching(model) for model in (alone, world.engine._model))
    assert len(there) > 2
    assert here == pytest.approx(there, abs=1e-7)


def _touching(model: Any) -> Any:
    """Return the depths of the contacts at random orientations."""
    data, draw, found = mujoco.MjData(model), np.random.default_rng(2), []
    for _ in range(20):
        data.qpos[3:7] = draw.normal(size=4)
        mujoco.mj_forward(model, data)
        found += sorted(data.contact.dist.tolist())
    return found


def test_a_pointer_of_git_lfs_is_not_a_mesh(tmp_path: Path) -> None:
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "shell.stl").write_text("version https://git-lfs.github.com/spec/v1\noid x\n")
    (tmp_path / "robot.xml").write_text(ROBOT)
    assert "the mesh 'shell.stl' is a Git LFS pointer" in str(read_scene(tmp_path / "robot.xml").warnings[0])


def test_a_file_that_is_not_a_mesh_is_still_an_error(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "shell.stl").write_text("nothing")
    with golden.raises(SceneError, match="MuJoCo"):
        told(tmp_path)


def test_warnings_of_mujoco_about_saved_files_are_not_reported(tmp_path: Path) -> None:
    """Names without a prefix are right as long as the model is not saved."""
    arm = '<mujoco><worldbody><body name="b"><joint name="j"/><geom size="0.1"/></body></worldbody></mujoco>'
    (tmp_path / "arm.xml").write_text(arm)
    (tmp_path / "room.xml").write_text(
        '<mujoco><asset><model name="arm" file="arm.xml"/></asset><worldbody>'
        '<body name="stand"><geom size="0.1"/><frame><attach model="arm" body="b" prefix=""/></frame>'
        "</body></worldbody></mujoco>"
    )
    backend = worlds().load("mujoco")
    with backend.open(read_scene(tmp_path / "room.xml"), seed=1, options=backend.options()) as world:
        world.run_until(10_000_000)
        assert not list(world.warnings)
