"""Bags as bodies: those that the library ``rosbags`` writes, and recordings of this platform."""

from __future__ import annotations

import json
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nrp_core import worlds
from nrp_core.errors import BackendLoadError, NrpError
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.sensor_msgs import Image
from nrp_core.recording import FilesRead
from nrp_core.world import Scene, World, read_scene
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from nrp_world_ros.bag import Bag

QOS = ("history", "depth", "reliability", "durability", "liveliness", "avoid_ros_namespace_conventions")
QOS_TIMES, TIME = ("deadline", "lifespan", "liveliness_lease_duration"), {"sec": 1, "nsec": 0}
BEGIN_NS, PERIOD_NS, COUNT = 1_700_000_000_123_456_789, 33_000_000, 30
PIXELS = np.full((4, 6, 3), (200, 30, 60), np.uint8)  # BGR
ROOM = """<sdf version="1.9"><world name="w"><model name="r"><link name="base"><sensor name="eye"
type="camera"><topic>/eye</topic><update_rate>30</update_rate><camera><image><width>6</width><height>4</height></image>
</camera></sensor></link><plugin name="d" filename="libgazebo_ros_planar_move.so">
<commandTopic>/cmd_vel</commandTopic><odometryTopic>/odom</odometryTopic></plugin></model></world></sdf>"""


def messages(store: Any, has_seq: bool) -> Iterator[tuple[str, int, Any]]:
    """Yield topic, time and message; the library makes its classes from ROS's definitions."""
    types, first = store.types, {"seq": 7} if has_seq else {}

    def header(t_ns: int) -> Any:
        stamp = types["builtin_interfaces/msg/Time"](*divmod(t_ns, 10**9))
        return types["std_msgs/msg/Header"](**first, stamp=stamp, frame_id="odom")

    point, turn, vector = (types[f"geometry_msgs/msg/{name}"] for name in ("Point", "Quaternion", "Vector3"))
    none = np.zeros(36)
    for i in range(COUNT):
        t_ns = BEGIN_NS + i * PERIOD_NS
        pose = types["geometry_msgs/msg/Pose"](point(0.1 * i, 0.0, 0.5), turn(0.0, 0.0, 0.6, 0.8))
        twist = types["geometry_msgs/msg/Twist"](vector(1.0 + i, 0.0, 0.0), vector(0.0, 0.0, 0.5))
        held = (
            types["geometry_msgs/msg/PoseWithCovariance"](pose, none),
            types["geometry_msgs/msg/TwistWithCovariance"](twist, none),
        )
        yield "/odom", t_ns, types["nav_msgs/msg/Odometry"](header(t_ns), "base", *held)
        data = cv2.imencode(".png", PIXELS)[1].ravel()
        yield "/eye/compressed", t_ns + 5, types["sensor_msgs/msg/CompressedImage"](header(t_ns), "png", data)
        yield "/heat", t_ns + 9, types["lab_msgs/msg/Heat"](header(t_ns), 20.5 + i)


def write_1(path: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("std_msgs/Header header\nfloat32 celsius", "lab_msgs/msg/Heat"))
    with Writer1(path.with_suffix(".bag")) as bag:
        known: dict[str, Any] = {}
        for topic, t_ns, message in messages(store, has_seq=True):
            name = message.__msgtype__
            known[topic] = known.get(topic) or bag.add_connection(topic, name, typestore=store)
            bag.write(known[topic], t_ns, store.serialize_ros1(message, name))
    return path.with_suffix(".bag")


def write_2(path: Path, storage: StoragePlugin) -> Path:
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("std_msgs/Header header\nfloat32 celsius", "lab_msgs/msg/Heat"))
    with Writer2(path, version=9, storage_plugin=storage) as bag:
        known: dict[str, Any] = {}
        for topic, t_ns, message in messages(store, has_seq=False):
            name = message.__msgtype__
            known[topic] = known.get(topic) or bag.add_connection(topic, name, typestore=store)
            bag.write(known[topic], t_ns, store.serialize_cdr(message, name))
    return path


WRITERS: dict[str, Callable[[Path], Path]] = {
    "bag": write_1,
    "sqlite3": lambda path: write_2(path, StoragePlugin.SQLITE3),
    "folder": lambda path: write_2(path, StoragePlugin.MCAP),
    "mcap": lambda path: next(write_2(path, StoragePlugin.MCAP).glob("*.mcap")),
}


@contextmanager
def played(path: Path, scene: Scene) -> Iterator[World]:
    backend = worlds().load("ros")
    options = backend.options.model_validate({"bag": path, "timestep": "10 ms"})
    with backend.open(scene, seed=1, options=options) as world:
        yield world


@pytest.mark.parametrize("kind", WRITERS)
def test_the_messages_of_a_bag_arrive_at_their_times(kind: str, tmp_path: Path) -> None:
    with played(WRITERS[kind](tmp_path / "drive"), Scene(())) as world:
        assert world.topics["/odom"].type is Odometry
        assert world.topics["/odom"].rate_hz == pytest.approx(1e9 / PERIOD_NS, rel=0.05)
        assert "/heat" not in world.topics  # this type has no class here
        odometry = world.subscribe("/odom", depth=None)
        world.run_until(500_000_000)
        heard = odometry.take()
        assert [each.t_ns for each in heard] == [i * PERIOD_NS for i in range(16)]
        assert [each.message.twist.twist.linear.x for each in heard] == [1.0 + i for i in range(16)]
        assert heard[3].message.header.stamp.to_ns() == BEGIN_NS + 3 * PERIOD_NS
        assert heard[3].message.header.frame_id == "odom"
        late = world.subscribe("/eye/compressed", depth=None)
        world.run_until(2_000_000_000)
        assert [each.t_ns for each in odometry.take()] == [i * PERIOD_NS for i in range(16, COUNT)]
        assert [each.t_ns for each in late.take()] == [i * PERIOD_NS + 5 for i in range(16, COUNT)]
        left_out, ended = world.warnings
        assert (left_out.code.name, ended.code.name) == ("NRP282", "NRP278")
        assert "/heat (lab_msgs/msg/Heat)" in str(left_out)
        world.reset()
        world.run_until(100_000_000)
        assert [each.t_ns for each in odometry.take()] == [0, PERIOD_NS, 2 * PERIOD_NS, 3 * PERIOD_NS]


def test_a_bag_moves_the_models_of_a_scene_and_is_seen_by_their_cameras(tmp_path: Path) -> None:
    (tmp_path / "room.sdf").write_text(ROOM)
    with played(write_1(tmp_path / "drive"), read_scene(tmp_path / "room.sdf")) as world:
        eye = world.subscribe("/eye", depth=None)
        world.advertise("/cmd_vel").publish(Twist())
        world.run_until(100_000_000)
        images = eye.take()
        assert len(images) == 4
        assert isinstance(images[0].message, Image)
        assert (images[0].message.data == PIXELS[:, :, ::-1]).all()
        assert world.model_motion("r").pose.position == pytest.approx((0.3, 0.0, 0.5))
        assert world.model_motion("r").linear == pytest.approx((4.0 * 0.28, 4.0 * 0.96, 0.0))


EXPERIMENT = """
name: heard
timestep: 10 ms
duration: 1 s
brain: {backend: event, model: brain.py}
transfer_functions: [hear.py]
world: {backend: ros, options: {bag: drive.bag}}
"""
BRAIN = "import pyNN.nest as sim\nsim.setup()\ncircuit = sim.Population(1, sim.IF_curr_exp())\n"
HEAR = """
@nrp.MapRobotSubscriber("odometry", Topic("/odom", nav_msgs.msg.Odometry))
@nrp.MapRobotPublisher("speed", Topic("/speed", std_msgs.msg.Float64))
@nrp.Neuron2Robot()
def hear(t, odometry, speed):
    if odometry.value is not None:
        speed.send_message(std_msgs.msg.Float64(odometry.value.twist.twist.linear.x))


@nrp.MapRobotSubscriber("speed", Topic("/speed", std_msgs.msg.Float64))
@nrp.MapVariable("most", initial_value=0.0)
@nrp.Robot2Neuron()
def keep(t, speed, most):
    if speed.value is not None:
        most.value = max(most.value, speed.value.data)
        if t > 0.97:
            raise RuntimeError(f"most {most.value}")
"""


def nrp(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-P", "-m", "nrp_core", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.slow
def test_functions_read_the_topics_of_a_bag_without_a_robot_file(tmp_path: Path) -> None:
    write_1(tmp_path / "drive")
    for name, text in (("heard.yaml", EXPERIMENT), ("brain.py", BRAIN), ("hear.py", HEAR)):
        (tmp_path / name).write_text(text)
    done = nrp(Path("/"), "run", str(tmp_path / "heard.yaml"))
    assert "NRP239" not in done.stdout + done.stderr  # the functions were tried before
    assert f"most {float(COUNT)}" in done.stdout + done.stderr


@pytest.mark.heavy
def test_a_recording_is_a_bag_that_excites_the_brain_as_its_run_did(tmp_path: Path) -> None:
    run = ("run", "braitenberg_husky", "--until", "0.5s", "--json")
    recorded = nrp(tmp_path, *run, "--record", "visit", "-s", "world.options.image_scale=0.25")
    assert recorded.returncode == 0, recorded.stderr
    body = "world.options={bag: visit/recording.mcap}"
    heard = nrp(tmp_path, *run, "--world", "ros", "-s", body)
    assert heard.returncode == 0, heard.stderr
    first, second = (json.loads(each.stdout) for each in (recorded, heard))
    assert first["spikes"] == second["spikes"]
    assert first["final_pose"]["husky"] == pytest.approx(second["final_pose"]["husky"], abs=1e-12)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"bag": "none.bag"}, "none.bag"),
        ({"bag": "none.txt"}, "none.txt"),
        ({"bag": "none.txt", "ros": 2}, "'ros'"),
    ],
)
def test_a_bag_that_cannot_be_read_is_refused(options: dict[str, Any], words: str, tmp_path: Path) -> None:
    backend = worlds().load("ros")
    (tmp_path / "none.txt").write_text("nothing")
    given = {**options, "bag": tmp_path / options["bag"]}
    with pytest.raises((NrpError, ValueError), match=words):
        backend.topics(backend.options.model_validate(given))


def edit_metadata(folder: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    path = folder / "metadata.yaml"
    content = yaml.safe_load(path.read_text())
    change(content["rosbag2_bagfile_information"])
    path.write_text(yaml.safe_dump(content))
    return folder


def without_counts(metadata: dict[str, Any]) -> None:
    for each in metadata["topics_with_message_count"]:
        each["message_count"] = 0


def with_another(key: str, value: object) -> Callable[[dict[str, Any]], None]:
    def change(metadata: dict[str, Any]) -> None:
        metadata["topics_with_message_count"][0]["topic_metadata"][key] = value

    return change


@pytest.mark.parametrize(
    "change",
    [
        without_counts,
        with_another("name", "/elsewhere"),
        with_another("type", "std_msgs/msg/String"),
        with_another("offered_qos_profiles", [{**dict.fromkeys(QOS, 1), **dict.fromkeys(QOS_TIMES, TIME)}]),
        lambda metadata: metadata["topics_with_message_count"].pop(0),
    ],
)
def test_a_folder_whose_metadata_names_other_messages_is_refused(change: Any, tmp_path: Path) -> None:
    path = edit_metadata(write_2(tmp_path / "drive", StoragePlugin.SQLITE3), change)
    with pytest.raises(BackendLoadError, match=r"metadata\.yaml.*/odom") as refused:
        Bag(path)
    assert "reindex" in str(refused.value)


def test_the_files_of_a_bag_are_played_by_their_times_whatever_the_metadata_says(tmp_path: Path) -> None:
    path = write_2(tmp_path / "drive", StoragePlugin.SQLITE3)
    first, second = path / "drive.db3", path / "late.db3"
    middle_ns = BEGIN_NS + COUNT // 2 * PERIOD_NS
    shutil.copy(first, second)
    for file, unwanted in ((first, f"timestamp >= {middle_ns}"), (second, f"timestamp < {middle_ns}")):
        with closing(sqlite3.connect(file)) as connection, connection:
            connection.execute(f"DELETE FROM messages WHERE {unwanted}")

    def disorder(metadata: dict[str, Any]) -> None:
        metadata["relative_file_paths"] = [second.name, first.name]
        metadata["starting_time"]["nanoseconds_since_epoch"] += 10**12
        metadata["duration"]["nanoseconds"] = 0

    with played(edit_metadata(path, disorder), Scene(())) as world:
        odometry = world.subscribe("/odom", depth=None)
        world.run_until(900_000_000)
        assert [each.t_ns for each in odometry.take()] == [i * PERIOD_NS for i in range(28)]
        assert [each.code.name for each in world.warnings] == ["NRP282"]  # it has not ended


@pytest.mark.parametrize("kind", WRITERS)
@given(data=st.data())
@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damage_of_a_bag_is_an_error_that_names_it(kind: str, data: Any, whole_bags: dict[str, Path]) -> None:
    path = whole_bags[kind]
    file = path if path.is_file() else next(each for each in path.iterdir() if each.suffix != ".yaml")
    whole = file.read_bytes()
    at = data.draw(st.integers(0, len(whole) - 1) | st.integers(1, 6000).map(lambda n: len(whole) - n))
    damage = data.draw(st.binary(max_size=200))
    file.write_bytes(whole[:at] + damage + whole[at + len(damage) :] if damage else whole[:at])
    try:
        with suppress(NrpError), played(path, Scene(())) as world:
            world.subscribe("/odom")
            world.run_until(200_000_000)
    finally:
        file.write_bytes(whole)


@pytest.fixture(scope="module")
def whole_bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("bags")
    return {kind: write(folder / kind) for kind, write in WRITERS.items()}


@pytest.mark.parametrize("kind", WRITERS)
def test_a_recording_keeps_all_files_of_a_bag(kind: str, whole_bags: dict[str, Path]) -> None:
    path = whole_bags[kind]
    with FilesRead() as files, Bag(path):
        pass
    assert files.below([path.parent]) == (sorted(path.iterdir()) if path.is_dir() else [path])


def test_a_bag_without_messages_is_refused(tmp_path: Path) -> None:
    with Writer1(tmp_path / "none.bag") as bag:
        bag.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=get_typestore(Stores.ROS1_NOETIC))
    with pytest.raises(BackendLoadError, match=r"none\.bag"):
        Bag(tmp_path / "none.bag")


def test_topics_that_the_bag_lacks_or_has_with_other_messages_are_named(tmp_path: Path) -> None:
    path = write_1(tmp_path / "drive")
    for topic, words in (
        ("/eyes", "no messages on /eyes.*/eye/compressed"),
        ("/odom", "are nav_msgs.*not sensor_msgs"),
        ("/heat", "unknown.*/heat .lab_msgs/msg/Heat"),
    ):
        (tmp_path / "room.sdf").write_text(ROOM.replace("<topic>/eye<", f"<topic>{topic}<").replace(
            "odometryTopic>/odom", "odometryTopic>/other"))  # fmt: skip
        with played(path, read_scene(tmp_path / "room.sdf")) as world:
            world.subscribe(topic)
            with pytest.raises(NrpError, match=words):
                world.run_until(100_000_000)
