"""Robots without ground, and robots inside the ground: reported before the run and while they fall."""

from __future__ import annotations

from functools import reduce
from math import sqrt
from pathlib import Path

import cv2
import nrp_experiments
import numpy as np
import pytest
from golden import Golden
from nrp_legacy.reader import read_exc

from nrp_core.checks.subjects.start_poses import wrong_starts
from nrp_core.checks.validate import validate_file
from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment, shipped
from nrp_core.findings import Code
from nrp_core.running import open_run
from nrp_core.scene.model import Scene

SHIPPED = Path(nrp_experiments.__file__).parent / "braitenberg_husky"
CORPUS = Path(__file__).parents[2] / "plugins" / "nrp-legacy" / "tests" / "corpus"
EXPERIMENT = f"""
name: footing
timestep: 20 ms
duration: 2 s
brain: {{backend: event, model: {SHIPPED}/brain.py}}
world:
  backend: mujoco
  scene: room.sdf
  robots: {{husky: {{model: {SHIPPED}/husky.sdf, pose: [0, 0, 0.2, 0, 0, 0]}}}}
"""
SLAB = "<collision name='slab'><geometry><box><size>40 40 0.2</size></box></geometry></collision>"
POST = """<collision name='post'><pose>9 0 0.5 0 0 0</pose>
<geometry><box><size>0.2 0.2 1</size></box></geometry></collision>"""
ROOM = """<sdf version="1.9"><world name="room"><gravity>0 0 {gravity}</gravity>
<model name="room"><static>true</static><pose>0 0 -0.1 0 0 0</pose>
<link name="body">{collision}</link></model></world></sdf>"""


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    (tmp_path / "experiment.yaml").write_text(EXPERIMENT)
    room(tmp_path, SLAB)
    return tmp_path / "experiment.yaml"


def room(folder: Path, collision: str, gravity: float = -9.8) -> None:
    (folder / "room.sdf").write_text(ROOM.format(collision=collision, gravity=gravity))


def codes(experiment: Path, *overrides: str) -> list[Code]:
    """Return the codes about the start of robots that a check finds, without a simulator."""
    found = [finding.code for finding in validate_file(experiment, list(overrides))]
    return [code for code in found if code in (Code.NRP291, Code.NRP292)]


@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_a_robot_without_ground_is_reported_before_it_falls_and_when_it_has(
    experiment: Path, world: str
) -> None:
    room(experiment.parent, POST)
    assert codes(experiment) == [Code.NRP292]
    with open_run(experiment, [f"world.backend={world}"]) as run:
        assert [problem.code for problem in run.problems] == [Code.NRP292]
        run.run()
        result = run.result()
    assert result.final_pose["husky"]["z"] == pytest.approx(0.2 - 9.8 / 2 * 2.0**2, rel=0.02)
    fallen, _ = [problem for problem in result.problems if problem.code is Code.NRP292]
    lowest_m = -0.1  # of the post, which is 1 m high about z = 0.4 m
    t_s = sqrt(2 * (0.2 - (lowest_m - 2.0)) / 9.8)
    told_s = float(fallen.message.rsplit(" at ", 1)[1].removesuffix(" s"))
    assert told_s == pytest.approx(t_s, abs=0.04)
    assert result.complete


@pytest.mark.parametrize(("floor", "expected"), [("", [Code.NRP292]), ("<static>true</static>", [])])
def test_a_floor_that_falls_is_reported(experiment: Path, floor: str, expected: list[Code]) -> None:
    path = experiment.parent / "room.sdf"
    path.write_text(path.read_text().replace("<static>true</static>", floor))
    assert codes(experiment) == expected


def test_a_loose_thing_on_the_floor_is_not_reported(experiment: Path) -> None:
    ball = """<model name="ball"><pose>3 0 1 0 0 0</pose><link name="ball"><collision name="ball">
    <geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link></model>"""
    path = experiment.parent / "room.sdf"
    path.write_text(path.read_text().replace("</world>", f"{ball}</world>"))
    assert codes(experiment) == []
    path.write_text(path.read_text().replace("<pose>3 0 1", "<pose>30 0 1"))  # beside the slab
    assert codes(experiment) == [Code.NRP292]


@pytest.mark.parametrize(
    ("z", "expected"),
    [(0.2, []), (0.1, []), (0.0, [Code.NRP291]), (-0.1, [Code.NRP291]), (-3.0, [Code.NRP292])],
)
def test_a_robot_inside_the_ground_is_reported(experiment: Path, z: float, expected: list[Code]) -> None:
    assert codes(experiment, f"world.robots.husky.pose=[0, 0, {z}, 0, 0, 0]") == expected


def test_a_robot_inside_a_wall_is_reported_with_both_shapes_and_the_depth(
    experiment: Path, golden: Golden
) -> None:
    room(experiment.parent, SLAB + POST)
    with open_run(experiment, ["world.robots.husky.pose=[9, 0, 0.2, 0, 0, 0]"]) as run:
        (problem,) = run.problems
    assert problem.code is Code.NRP291
    assert "'room/body/post'" in problem.message
    golden(problem.message)  # half of its thickness


@pytest.mark.parametrize(("x", "expected"), [(0, [Code.NRP291]), (0.5, [Code.NRP291]), (1.2, [])])
def test_a_robot_inside_a_loose_thing_is_reported(experiment: Path, x: float, expected: list[Code]) -> None:
    """The crate is 1 m wide; the Husky is 1 m long and turned about."""
    crate = f"""<model name="crate"><pose>{x} 0 0.5 0 0 0</pose><link name="l"><collision name="c">
    <geometry><box><size>1 1 1</size></box></geometry></collision></link></model></world>"""
    path = experiment.parent / "room.sdf"
    path.write_text(path.read_text().replace("</world>", crate))
    assert codes(experiment) == expected


@pytest.mark.parametrize(
    ("x", "z", "expected"), [(-2, 1.3, []), (2, 0.5, []), (-2, 0.5, [Code.NRP291]), (2, -0.4, [Code.NRP291])]
)
def test_a_robot_inside_a_height_map_is_reported(
    experiment: Path, x: float, z: float, expected: list[Code]
) -> None:
    """The map has two plateaus, 1 m high at x < 0 and 0 m at x > 0; the wheels reach 0.13 m down."""
    plateaus = np.repeat(np.array([[255, 0]], np.uint8), 16, axis=1).repeat(32, axis=0)
    cv2.imwrite(str(experiment.parent / "plateaus.png"), plateaus)
    ground = "<heightmap><uri>plateaus.png</uri><size>8 8 1</size><pos>0 0 0.1</pos></heightmap>"
    room(experiment.parent, f"<collision name='c'><geometry>{ground}</geometry></collision>")
    assert codes(experiment, f"world.robots.husky.pose=[{x}, 0, {z}, 0, 0, 0]") == expected


def test_without_gravity_a_robot_may_start_anywhere(experiment: Path) -> None:
    room(experiment.parent, POST, gravity=0.0)
    assert codes(experiment, "world.robots.husky.pose=[0, 0, 5, 0, 0, 0]") == []
    with open_run(experiment, ["world.robots.husky.pose=[0, 0, -5, 0, 0, 0]"]) as run:
        run.run(0.2)
        assert not run.problems


def scene_of(experiment: Experiment) -> Scene:
    maker = maker_of(experiment)
    robots = [maker.robot(experiment, name) for name in experiment.world.robots]
    return reduce(Scene.with_model, robots, maker.room(experiment))


@pytest.mark.parametrize("name", shipped())
def test_no_shipped_robot_starts_in_a_wrong_place(name: str) -> None:
    experiment = load_experiment(name)
    assert list(wrong_starts(scene_of(experiment), experiment.world.robots)) == []


@pytest.mark.parametrize("path", sorted(CORPUS.glob("*/*.exc")), ids=lambda path: path.parent.name)
def test_no_robot_of_the_corpus_starts_in_a_wrong_place(path: Path) -> None:
    experiment = read_exc(path, [f"models=[{CORPUS / 'models'}]"])
    robots = {name: one for name, one in experiment.world.robots.items() if one.model.is_file()}
    world = experiment.world.model_copy(update={"robots": robots})
    present = experiment.model_copy(update={"world": world})
    assert list(wrong_starts(scene_of(present), robots)) == []
