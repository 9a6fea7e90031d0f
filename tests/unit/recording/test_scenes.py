"""The recorded scene and its frames, with real engines and a decoder that is not ours."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from nrp_core import load_experiment, worlds
from nrp_core.experiment.running.run import Run
from nrp_core.recording.layout import MCAP_NAME, SCENE, TRANSFORMS
from nrp_core.recording.reading.shapes import RecordedScene, ShapeKind
from nrp_core.recording.recording import Recording
from nrp_core.recording.writing.frames import SceneFrames, to_poses
from nrp_core.recording.writing.recorder import McapRecorder
from nrp_core.recording.writing.scenery import scene_update, shown_visuals
from nrp_core.scene.model import Capsule, Inertial, Joint, Link, Mesh, Model, Scene, Visual
from nrp_core.scene.rigid import Pose, matrix_of
from nrp_core.world.model_states import transform_pose
from nrp_core.world.sensors.laser import Laser

WORLDS = ("mujoco", "pybullet")
components = st.floats(-1.0, 1.0)
turns = st.tuples(components, components, components, components).filter(lambda q: sum(map(abs, q)) > 0.1)


@given(turns, turns)
def test_poses_of_what_is_fixed_to_frames_are_those_of_an_independent_library(
    frame: tuple[float, ...], inner: tuple[float, ...]
) -> None:
    outer, held = Rotation.from_quat(frame), Rotation.from_quat(inner)
    frames = np.column_stack([outer.as_matrix(), (1.0, 2.0, 3.0)])[np.newaxis]
    in_frames = np.column_stack([held.as_matrix(), (0.1, -0.2, 0.3)])[np.newaxis]
    poses = np.empty((1, 7))
    to_poses(frames, in_frames, poses)
    np.testing.assert_allclose(poses[0, :3], np.add(outer.apply((0.1, -0.2, 0.3)), (1, 2, 3)), atol=1e-12)
    turned = Rotation.from_quat(poses[0, 3:])
    np.testing.assert_allclose(turned.as_matrix(), (outer * held).as_matrix(), atol=1e-9)


@pytest.fixture(scope="module", params=WORLDS)
def walked(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Pose]]:
    """A recording of the hexapod's first steps, and where the engine says its links are at the end."""
    folder = tmp_path_factory.mktemp("walk")
    experiment = load_experiment("walking_hexapod", [f"world.backend={request.param}"])
    with Run(experiment) as run:
        recorder = McapRecorder(run.brain, run.world, folder, period_ns=experiment.timestep)
        for _ in range(30):
            run.step()
            recorder.step()
        engine = run.world.engine
        links = {f"hexapod/{link.name}" for link in run.world.scene.model("hexapod").links}
        recorder.close()
        at = {name: engine.link_motion(*name.split("/")).pose for name in links}
    return folder, at


@pytest.mark.one_of(3)
def test_links_are_where_the_engine_says(walked: tuple[Path, dict[str, Pose]]) -> None:
    folder, at = walked
    *_, last = Recording(folder).messages({TRANSFORMS})
    recorded = {each.child_frame_id: transform_pose(each.transform) for each in last.message.transforms}
    assert len(recorded) == 25
    for name, pose in recorded.items():
        np.testing.assert_allclose(matrix_of(pose), matrix_of(at[name]), atol=1e-6)  # Bullet gives 32 bits


def test_a_viewer_with_a_decoder_of_its_own_reads_scene_and_frames(
    walked: tuple[Path, dict[str, Pose]],
) -> None:
    folder, at = walked
    with (folder / MCAP_NAME).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        read = [(channel.topic, message) for _, channel, _, message in reader.iter_decoded_messages()]
    scenes = [message for topic, message in read if topic == SCENE]
    frames = [message for topic, message in read if topic == TRANSFORMS]
    children = {each.child_frame_id for each in frames[-1].transforms}
    used = {entity.frame_id for entity in scenes[0].entities}
    assert used <= children | {"world"}
    assert "hexapod/body" in used
    body = next(each for each in frames[-1].transforms if each.child_frame_id == "hexapod/body")
    assert body.transform.translation.x == pytest.approx(at["hexapod/body"].position[0], abs=1e-6)


@pytest.mark.parametrize("engine", WORLDS)
def test_the_frames_of_scans_are_where_their_sensors_are(engine: str) -> None:
    """Also of a sensor on a link that is fixed to another one, which is one body with it."""
    inertial = Inertial(1.0, inertia=(0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    mount = Pose.from_rpy((0.1, 0.2, 0.3), 0.0, 0.0, 0.5)
    arm = Link("arm", Pose((0.0, 0.0, 0.4)), sensors=(Laser("laser", "/scan", 10.0, pose=mount),))
    joint = Joint("held", "fixed", "base", "arm", arm.pose)
    rover = Model("rover", (Link("base", inertial=inertial), arm), (joint,), pose=Pose((3.0, 0.0, 1.0)))
    backend = worlds().load(engine)
    with backend.open(Scene((rover,)), seed=1, options=backend.options()) as world:
        world.run_until(100_000_000)
        frames = SceneFrames(world).now
        assert frames.names == ("rover/base", "rover/arm/laser")
        there = world.link_motion("rover", "arm").pose @ mount
        np.testing.assert_allclose(frames.poses()[1], (*there.position, *there.orientation), atol=1e-6)


def test_a_mesh_is_recorded_with_its_file_and_its_scale(tmp_path: Path) -> None:
    corner = "vertex 0 0 0 vertex 1 0 0 vertex 0 1 0".replace(" vertex", "\nvertex")
    (tmp_path / "body.stl").write_text(
        f"solid s\nfacet normal 0 0 1\nouter loop\n{corner}\nendloop\nendfacet\n"
    )
    (shape,) = _shapes(Visual("v", Mesh(tmp_path / "body.stl", (2.0, 2.0, -2.0))))
    assert (shape.kind, shape.size) == (ShapeKind.MESH, (2.0, 2.0, -2.0))
    assert shape.mesh is not None
    assert shape.mesh.tobytes() == (tmp_path / "body.stl").read_bytes()


def test_a_capsule_is_a_cylinder_with_two_balls() -> None:
    shapes = _shapes(Visual("v", Capsule(0.5, 2.0)))
    assert [shape.kind.name for shape in shapes] == ["ELLIPSOID", "ELLIPSOID", "CYLINDER"]
    assert [shape.pose.position[2] for shape in shapes] == [-1.0, 1.0, 0.0]


def test_a_model_that_leaves_the_scene_is_removed_from_the_recorded_one() -> None:
    shown = _shown(Visual("a", Capsule(0.5, 2.0)), Visual("b", Capsule(0.5, 2.0)))
    scene = RecordedScene()
    scene.take(scene_update({}, shown, 0))
    scene.take(scene_update(shown, {"thing/body/b": shown["thing/body/b"]}, 1))
    assert {shape.visual for shape in scene.shapes} == {"thing/body/b"}


def _shown(*visuals: Visual) -> Any:
    from nrp_core.dsl.testing import MockWorld

    world = MockWorld(scene=Scene((Model("thing", (Link("body", visuals=visuals),), static=True),)))
    return shown_visuals(world.scene, SceneFrames(world).now, {})


def _shapes(*visuals: Visual) -> Any:
    scene = RecordedScene()
    scene.take(scene_update({}, _shown(*visuals), 0))
    return scene.shapes
