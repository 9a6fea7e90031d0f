"""ROS's own tools, and what they see and do."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from nrp_core.world import Scene
from rosbags.highlevel import AnyReader

from conftest import Ros, needs_ros
from nrp_world_ros import RosBackend, RosOptions

pytestmark = [needs_ros, pytest.mark.slow]


def test_nodes_of_ros_see_the_robot_and_drive_it(bridged: Ros) -> None:
    ros = bridged
    topics = ros.run("rostopic", "list").split()
    assert {"/clock", "/tf", "/husky/camera", "/husky/odom", "/husky/cmd_vel"} <= set(topics)
    assert ros.run("rostopic", "type", "/husky/camera").strip() == "sensor_msgs/Image"
    assert "width: 80" in ros.run("rostopic", "echo", "-n", "1", "--noarr", "/husky/camera")

    def forward() -> float:
        return float(ros.run("rostopic", "echo", "-n", "1", "/husky/odom/pose/pose/position/x").split()[0])

    before = forward()
    drives = ("rostopic", "pub", "-r", "20", "/husky/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 1.0}}")
    driver = ros.start(*drives)
    ros.until(lambda: forward() > before + 0.5)
    driver.terminate()


def test_rosbag_records_what_another_reader_understands_and_this_one_plays(bridged: Ros) -> None:
    ros = bridged
    topics = ["/clock", "/tf", "/tf_static", "/husky/odom", "/husky/camera"]
    ros.run("rosbag", "record", "-O", "seen", "--duration", "3", *topics)
    with AnyReader([Path(ros.folder / "seen.bag")]) as bag:
        counts = {connection.topic: connection.msgcount for connection in bag.connections}
        assert sorted(counts) == sorted(topics)
        assert counts["/tf_static"] == 1  # sent before the recording began
        assert counts["/husky/camera"] > 30
        camera = [connection for connection in bag.connections if connection.topic == "/husky/camera"]
        stamps = []
        for connection, _, data in bag.messages(camera):
            image = bag.deserialize(data, connection.msgtype)
            assert image.data.size == 80 * 60 * 3
            stamps.append(image.header.stamp.sec + image.header.stamp.nanosec * 1e-9)
        assert (stamps[-1] - stamps[0]) / (len(stamps) - 1) == pytest.approx(1 / 30, rel=0.01)
    options = RosOptions.model_validate({"bag": ros.folder / "seen.bag", "timestep": "20 ms"})
    with RosBackend().open(Scene(()), seed=1, options=options) as world:
        heard = world.subscribe("/husky/camera", depth=None)
        world.run_until(10_000_000_000)
        assert len(heard.take()) == counts["/husky/camera"]


def test_a_run_with_its_brain_is_seen_too(ros: Ros) -> None:
    run = ros.nrp("ros-bridge", "braitenberg_husky", "--until", "8s", "-s", "world.options.image_scale=0.25")
    ros.until(lambda: "/husky/odom" in ros.run("rostopic", "list"))
    seen = ros.run("rostopic", "echo", "-n", "1", "/husky/odom/twist/twist/angular/z")
    assert re.match(r"-?\d", seen)
    said, _ = run.communicate(timeout=60)
    assert "in ROS" in said
    assert run.returncode == 0


def test_a_wrong_message_from_ros_is_dropped_with_a_warning(ros: Ros) -> None:
    body = ros.body()
    assert body.stdout is not None
    ros.run("rostopic", "pub", "-1", "/husky/cmd_vel", "geometry_msgs/Twist", "{linear: {x: .nan}}")
    said = next(line for line in body.stdout if "was dropped" in line)  # while it runs
    assert "linear.x" in said
    assert body.poll() is None


def test_the_check_sums_are_those_of_the_message_packages(bridged: Ros) -> None:
    """A node with other check sums would be refused: ROS's program compares them."""
    for topic in ("/husky/odom", "/husky/joint_states", "/clock"):
        done = subprocess.run(
            ["rostopic", "echo", "-n", "1", topic], env=bridged.env, capture_output=True, text=True,
            timeout=60, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert "secs:" in done.stdout
