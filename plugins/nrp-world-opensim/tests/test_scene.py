"""The scene that a file becomes, and where the engine says that its bodies are."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import opensim as osim
import pytest
from golden import Golden
from nrp_core import worlds
from nrp_core.errors import CapabilityError, DivergedError, SceneError
from nrp_core.world import (
    Box,
    Collision,
    Inertial,
    Link,
    Mesh,
    Model,
    Pose,
    Scene,
    ServoTarget,
    Visual,
    Wrench,
    read_scene,
    triangles_of,
)

from conftest import Open
from own_models import MODELS, arm, written

File = Callable[[str], Path]


def distance(a: Pose, b: Pose) -> float:
    """The largest difference of two poses; a quaternion and its negative are the same rotation."""
    turn = 1 - abs(np.dot(a.orientation, b.orientation))
    return float(max(np.abs(np.subtract(a.position, b.position)).max(), turn))


@pytest.mark.parametrize("name", MODELS)
def test_links_start_where_the_engine_has_its_bodies(name: str, file_of: File, open_world: Open) -> None:
    from nrp_core.world.drives.muscles import start_places

    place = Pose.from_rpy((1.0, 2.0, 3.0), 0.0, 0.0, 0.7)
    world = open_world(file_of(name), pose=place)
    model = world.scene.model(name)
    places = start_places(model)
    for body in (link.name for link in model.links if "/" not in link.name):
        assert distance(world.link_motion(name, body).pose, place @ places[body]) < 1e-12


def test_coordinates_and_bodies_are_named_as_in_the_file(file_of: File, open_world: Open) -> None:
    world = open_world(file_of("knee"))
    names = "hip", "knee_angle", "patella_rz", "patella_tx", "patella_ty"
    assert world.joint_states("knee").names == names
    assert [joint.name for joint in world.scene.model("knee").joints if joint.kind != "fixed"] == list(names)
    locked = world.scene.model("knee").joint("patella_tx")
    assert (locked.lower, locked.upper) == (0.01, 0.01)
    positions = dict(zip(names, world.joint_states("knee").positions.tolist(), strict=True))
    assert positions["patella_rz"] == pytest.approx(0.5 * positions["knee_angle"] + 0.3, abs=1e-6)


def test_paths_wrap_as_in_opensim(tmp_path: Path, open_world: Open) -> None:
    path = written(arm(elbow=1.6), tmp_path)
    world = open_world(path)
    points = np.array(world.engine.muscle_path("arm", "extensor"))
    assert len(points) > 2  # straight from the upper arm to the forearm would be two
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    model = osim.Model(str(path))
    state = model.initSystem()
    arc = model.getMuscles().get("extensor").getLength(state)
    assert 0.99 * arc < length <= arc  # chords of the arc
    straight = np.array(world.engine.muscle_path("arm", "flexor"))
    assert np.linalg.norm(np.diff(straight, axis=0)) == pytest.approx(
        model.getMuscles().get("flexor").getLength(state), abs=1e-12
    )


def test_a_wrench_accelerates_a_free_body(file_of: File, open_world: Open) -> None:
    world = open_world(file_of("ball"), pose=Pose.from_rpy((0.0, 0.0, 5.0), 0.0, 0.0, pi / 3))
    engine = world.engine
    before = engine.link_motion("ball", "ball")
    engine.set_wrench("ball", "ball", Wrench((3.0, -1.0, 20.0), (0.0, 0.0, 0.002)), "test")
    engine.advance(10)
    after = engine.link_motion("ball", "ball")
    gained = np.subtract(after.linear, before.linear)
    np.testing.assert_allclose(gained, 0.02 * np.array([3.0, -1.0, 20.0 - 9.80665]), atol=1e-5)
    np.testing.assert_allclose(after.angular, (0.0, 0.0, 0.02 * 0.002 / 0.004), atol=1e-5)
    engine.set_wrench("ball", "ball", Wrench(), "test")
    engine.advance(10)
    fallen = np.subtract(engine.link_motion("ball", "ball").linear, after.linear)
    np.testing.assert_allclose(fallen, (0.0, 0.0, -0.02 * 9.80665), atol=1e-5)


def test_a_tilted_robot_falls_down_and_not_along_its_own_axis(file_of: File, open_world: Open) -> None:
    world = open_world(file_of("ball"), pose=Pose.from_rpy((0.0, 0.0, 5.0), pi / 2, 0.3, 0.2))
    before = world.engine.link_motion("ball", "ball").linear
    world.engine.advance(10)
    gained = np.subtract(world.engine.link_motion("ball", "ball").linear, before)
    np.testing.assert_allclose(gained, (0.0, 0.0, -0.02 * 9.80665), atol=1e-6)


def test_efforts_of_several_owners_add_up_on_a_coordinate(file_of: File, open_world: Open) -> None:
    first, second = (open_world(file_of("arm")).engine for _ in range(2))
    first.set_joint_effort("arm", "elbow", 0.7)
    first.set_servo_target("arm", "elbow", ServoTarget(effort=0.3))
    second.set_joint_effort("arm", "elbow", 1.0)
    for engine in (first, second):
        engine.advance(20)
    states = [engine.joint_states("arm") for engine in (first, second)]
    np.testing.assert_allclose(states[0].positions, states[1].positions, rtol=0, atol=1e-12)
    assert states[0].efforts.tolist() == [0.0, 1.0]


def test_meshes_of_vtk_are_drawn_and_missing_ones_are_named(tmp_path: Path, golden: Golden) -> None:
    model = arm()
    for name in ("bone.vtp", "lost.vtp", "packed.vtp"):
        model.getBodySet().get("forearm").attachGeometry(osim.Mesh(name))
    (tmp_path / "Geometry").mkdir()
    text = """<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="4" NumberOfPolys="1">
      <Points><DataArray NumberOfComponents="3" format="{0}">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>
      <Polys><DataArray Name="connectivity" format="ascii">0 1 2 3</DataArray>
      <DataArray Name="offsets" format="ascii">4</DataArray></Polys></Piece></PolyData></VTKFile>"""
    (tmp_path / "Geometry" / "bone.vtp").write_text(text.format("ascii"))
    (tmp_path / "packed.vtp").write_text(text.format("appended"))
    scene = read_scene(written(model, tmp_path))
    golden(*(warning.message for warning in scene.warnings))
    visuals = scene.model("arm").link("forearm").visuals
    (mesh,) = (each.geometry for each in visuals if isinstance(each.geometry, Mesh))
    vertices, triangles = triangles_of(mesh)
    corners = vertices[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(1.0)  # the square


def test_a_model_with_an_enabled_controller_is_refused_by_its_name(tmp_path: Path, golden: Golden) -> None:
    def with_controller(enabled: bool) -> Path:
        model, controller = arm(), osim.PrescribedController()
        controller.setName("spinal_cord")
        controller.set_enabled(enabled)
        model.addController(controller)
        return written(model, tmp_path)

    with golden.raises(SceneError, match="'spinal_cord'"):
        read_scene(with_controller(True))
    assert read_scene(with_controller(False)).models


def test_a_file_that_opensim_cannot_read_is_refused(tmp_path: Path, golden: Golden) -> None:
    path = tmp_path / "broken.osim"
    path.write_text('<OpenSimDocument Version="40500"><Model name="m"><JointSet><objects><PinJoint name="j">'
                    "<socket_parent_frame>/nothing</socket_parent_frame></PinJoint></objects></JointSet></Model>"
                    "</OpenSimDocument>")  # fmt: skip
    with golden.raises(SceneError, match="broken"):
        read_scene(path)


def test_other_models_are_refused_unless_they_are_only_drawn(
    file_of: File, open_world: Open, golden: Golden
) -> None:
    scene = read_scene(file_of("arm"))
    visual = Visual("board", Box((1.0, 0.1, 1.0)))
    board = Model("board", (Link("link", visuals=(visual,)),), static=True)
    world = open_world(Scene((*scene.models, board)))
    assert world.link_motion("board", "link").pose == Pose()
    solid = replace(board, links=(replace(board.links[0], collisions=(Collision("c", Box((1, 1, 1))),)),))
    with golden.raises(CapabilityError, match="'board'"):
        open_world(Scene((*scene.models, solid)))
    loose = replace(board, links=(replace(board.links[0], inertial=Inertial(1.0)),), static=False)
    with golden.raises(CapabilityError, match="'board'"):
        open_world(Scene((*scene.models, loose)))


def test_servos_are_refused_in_one_sentence(file_of: File, open_world: Open, golden: Golden) -> None:
    engine = open_world(file_of("arm")).engine
    with golden.raises(CapabilityError, match="'elbow'"):
        engine.set_servo_target("arm", "elbow", ServoTarget(stiffness=1.0, position=0.3))


def test_a_step_that_the_integrator_cannot_take_ends_the_run(
    file_of: File, open_world: Open, golden: Golden
) -> None:
    engine = open_world(file_of("arm")).engine
    engine.set_control("arm", "flexor", float("nan"))
    with golden.raises(DivergedError, match="'arm'") as caught:
        engine.advance(5)
    assert caught.value.t_ns == 0


def test_mujoco_refuses_the_muscles_of_a_file_of_opensim(file_of: File, golden: Golden) -> None:
    backend = worlds().load("mujoco")
    with golden.raises(CapabilityError, match="'flexor' of 'arm'"):
        backend.open(read_scene(file_of("arm")), seed=1, options=backend.options())
