"""Sensors that an experiment mounts on a robot measure as those of a file do, in both engines."""

from __future__ import annotations

import pytest
from golden import Golden
from jointed import axis, joint, limit, link

from nrp_core.errors import SceneError
from nrp_core.scene.rigid import Pose
from nrp_core.world.robot_setup import AddedSensor, JointControl, RobotSetup, set_up_robot, with_added_sensors

ARM = (
    link("base", at=(0, 0, 1))
    + link("bob", com=(0.2, 0, 0), at=(0, 0, 1))
    + joint("revolute", axis("0 1 0", limit(-2.0, 2.0)), parent="base")
)
SCAN = {"scan": {"horizontal": {"samples": 5, "min_angle": -1.0, "max_angle": 1.0}}, "range": {"max": 8}}
SENSORS = (
    AddedSensor("camera", "bob", "eye", settings={"camera": {"image": {"width": 8, "height": 6}}}),
    AddedSensor("imu", "bob", pose=Pose.from_rpy((0.1, 0, 0), 0, 0, 0), rate_hz=100.0),
    AddedSensor("contact", "bob", "touch"),
    AddedSensor("lidar", "base", settings={"lidar": SCAN}),
    AddedSensor("force_torque", "j"),
)


def test_sensors_of_every_kind_are_mounted_and_measure(open_world, read, advance):
    control = ((".*", JointControl("position")),)
    world = open_world(set_up_robot(read(ARM), RobotSetup(True, control=control, sensors=SENSORS)))
    topics = ("bob/eye/image", "bob/imu/imu", "bob/touch/contact", "base/lidar/scan")
    heard = {topic: world.subscribe(f"/robot/{topic}") for topic in topics}
    wrench = world.subscribe(next(topic for topic in world.topics if "force_torque" in topic))
    advance(world, 0.2)
    latest = {topic: feed.latest.message for topic, feed in heard.items() if feed.latest is not None}
    assert (latest["bob/eye/image"].height, latest["bob/eye/image"].width) == (6, 8)
    assert latest["bob/imu/imu"].header.frame_id == "robot/bob/imu"
    assert len(latest["base/lidar/scan"].ranges) == 5
    assert latest["bob/touch/contact"].states == []
    assert wrench.latest is not None


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        (AddedSensor("cammera", "bob"), "'cammera' is not a type of sensors; did you mean 'camera'?"),
        (AddedSensor("imu", "bbo"), "no link or joint 'bbo' for an added sensor; did you mean 'bob'?"),
        (AddedSensor("imu", "j"), "a sensor of type 'imu' is on a link, which 'j' is not"),
        (AddedSensor("force_torque", "bob"), "a sensor of type 'force_torque' is on a joint"),
        (AddedSensor("lidar", "bob", settings={"lidar": {"scna": 1}}), "<scna> is not an element of <lidar>"),
        (AddedSensor("camera", "bob", settings={"camera": {"horizontal_fov": 9}}), "must be below pi, not 9"),
    ],
)
def test_a_sensor_that_cannot_be_mounted_is_one_error(read, sensor, message):
    with pytest.raises(SceneError) as refusal:
        with_added_sensors(read(ARM), (sensor,))
    assert message in str(refusal.value)


def test_a_link_has_one_sensor_of_a_name(read, golden: Golden):
    with golden.raises(SceneError, match="'a'"):
        with_added_sensors(read(ARM), (AddedSensor("imu", "bob", "a"), AddedSensor("contact", "bob", "a")))


def test_mistakes_in_an_added_sensor_are_reported(read):
    def told(*sensors):
        return [one.message for one in with_added_sensors(read(ARM), sensors).warnings]

    before = told()
    second = AddedSensor("imu", "bob"), AddedSensor("imu", "bob")
    (renamed,) = set(told(*second)) - set(before)
    assert renamed.startswith(
        "'robot/bob' has a sensor 'imu' already: a further one without a name is called"
    )
    other = AddedSensor("lidar", "bob", settings={"camera": {"image": {"width": 8}}})
    (unread,) = set(told(other)) - set(before)
    assert unread == "<camera> has no effect in the sensor 'lidar', which is of type 'lidar'"
    assert told(AddedSensor("imu", "bob"), AddedSensor("imu", "bob", "other"), *SENSORS[2:]) == before
