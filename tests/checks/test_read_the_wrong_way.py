"""Parts of messages and images that are read the wrong way are reported, and the right way is not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Finding, Level

Slalom = Callable[[str, str, str], list[Finding]]

STEER = "slalom_pioneer/steer.py"
NEAREST = "Float64(float(ranges.min()))"
FORWARD = "SPEED * (left.rate + right.rate) / 2"
CAPPED = "np.minimum(beams.ranges, beams.range_max)"
STATES = """clearance.send_message(Float64(float(ranges.min())))


@nrp.MapRobotSubscriber("states", nrp.Topic("/gazebo/model_states", ModelStates))
@nrp.MapRobotSubscriber("odom", nrp.Topic("/pioneer/odom", Odometry))
@nrp.MapSpikeSource("left", nrp.brain.feelers[0], nrp.dc_source)
@nrp.Robot2Neuron()
def more(t, states, odom, left):
    left.amplitude = {}
"""


def _warnings(found: list[Finding]) -> list[str]:
    unused = (Code.NRP220, Code.NRP230, Code.NRP231)
    return [one.message for one in found if one.level is not Level.NOTE and one.code not in unused]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (NEAREST, "Float64(np.mean(beams.ranges))", "'np.mean(beams.ranges)' is not finite as soon"),
        (NEAREST, "Float64(beams.ranges[80:100].mean())", "[80:100].mean()' is not finite as soon"),
        (NEAREST, "Float64(ranges.mean())", ""),
        (NEAREST, "Float64(np.min(beams.ranges))", ""),
        (NEAREST, "Float64(ranges[int(-1.57 / beams.angle_increment)])", "has a negative index, which"),
        (NEAREST, "Float64(ranges[int((-1.57 - beams.angle_min) / beams.angle_increment)])", ""),
        (NEAREST, "Float64(ranges[int(1.57 / beams.angle_increment)])", ""),
        (CAPPED, "np.minimum(beams.ranges, beams.range_min)", "is never above the smallest range"),
        (CAPPED, "np.maximum(beams.ranges, beams.range_min)", ""),
        (FORWARD, "SPEED * (left.rate + left.rate) / 2", "'left.rate + left.rate' has the same value twice"),
        (FORWARD, "SPEED * left.rate * left.rate", ""),
        (FORWARD, "SPEED * (abs(left.rate - right.rate) < 0)", "< 0' is always False: abs is never negative"),
        (FORWARD, "SPEED * (len([left]) >= 0)", "is always True: len is never negative"),
        (FORWARD, "SPEED * (abs(left.rate - right.rate) > 0)", ""),
        (NEAREST, "Float64(ranges[120:60].max())", "'ranges[120:60]' is always empty: it begins at 120"),
        (NEAREST, "Float64(ranges[120:60:-1].max())", ""),
        (NEAREST, "Float64(ranges[60:-60].max())", ""),
        (NEAREST, "Float64(1.0 if min(beams.ranges) > 4000 else 0.0)", "a distance with 4000 m"),
        (NEAREST, "Float64(1.0 if beams.ranges[60:120].min() < 50 else 0.0)", "a distance with 50 m"),
        (NEAREST, "Float64(1.0 if min(beams.ranges) > 3.5 else 0.0)", ""),
        (NEAREST, "Float64(1.0 if ranges.min() < 50 else 0.0)", ""),
        (NEAREST, "Float64(beams.ranges[359])", "ranges[359]' is out of range: the scanner has 181"),
        (NEAREST, "Float64(beams.ranges[180])", ""),
        (NEAREST, "Float64(beams.ranges[-181])", ""),
        (NEAREST, "Float64(len(beams.intensities))", "'beams.intensities' has no value: no sensor of"),
    ],
)  # fmt: skip
def test_distances_and_rates_are_read_as_they_are(slalom: Slalom, old: str, new: str, words: str) -> None:
    found = _warnings(slalom(STEER, old, new))
    assert [words in one for one in found] == [True] * bool(words), found


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("states.value.pose[0].position.x", "'states.value.pose[0]' is that of 'floor', which is static"),
        ("states.value.pose[5].position.x", ""),  # the robot
        ("states.value.pose[states.value.name.index('pioneer')].position.x", ""),
        ("np.sin(odom.value.pose.pose.orientation.z)", "is part of a quaternion, not an angle"),
        ("1.57 - odom.value.pose.pose.orientation.z", "is part of a quaternion, not an angle"),
        ("odom.value.pose.pose.orientation.z + np.pi", "is part of a quaternion, not an angle"),
        ("1 - odom.value.pose.pose.orientation.z", ""),
        ("2 - odom.value.pose.pose.orientation.z * 2", ""),
        ("np.degrees(odom.value.pose.pose.orientation.z)", "is part of a quaternion, not an angle"),
        ("odom.value.pose.covariance[0]", "'odom.value.pose.covariance' has no value: no sensor of"),
        ("2 * np.arcsin(odom.value.pose.pose.orientation.z)", ""),
        ("np.radians(odom.value.twist.twist.angular.z)", "takes a turn rate in rad/s as degrees"),
        ("np.degrees(odom.value.twist.twist.angular.z)", ""),
        ("t - odom.value.header.stamp.nanosec", "'nanosec' are the nanoseconds since the last whole second"),
        ("t - odom.value.header.stamp.to_sec()", ""),
        ("t - odom.value.header.stamp.sec - odom.value.header.stamp.nanosec * 1e-9", ""),
    ],
)
def test_states_and_stamps_are_read_as_they_are(slalom: Slalom, value: str, words: str) -> None:
    imports = "from gazebo_msgs.msg import ModelStates\nfrom nav_msgs.msg import Odometry\n"
    slalom(STEER, "from sensor_msgs", f"{imports}from sensor_msgs")
    found = _warnings(slalom(STEER, f"clearance.send_message({NEAREST})\n", STATES.format(value)))
    assert [words in one for one in found] == [True] * bool(words), found


SEEN = """\
import cv2; import numpy as np
from cv_bridge import CvBridge
from sensor_msgs.msg import Image


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.Robot2Neuron()
def see(t, camera, eye):
    {}
"""
PIXELS = """\
image = CvBridge().imgmsg_to_cv2(camera.value, "rgb8")
    image = cv2.cvtColor(image, cv2.COLOR_{}2HSV)
    mask = cv2.inRange(image, np.array([{}, 30, 30]), np.array([{}, 255, 255]))
    eye.rate = 1000.0 * mask.mean() / 255"""
CENTRE = """\
image = camera.value
    centre = nrp.tf_lib.find_centroid_hsv(image, (0, 30, 30), (0, 255, 255))
    if centre is not None:
        eye.rate = max(0.0, {})"""
SHARE = """\
found = nrp.tf_lib.detect_red(camera.value)
    eye.rate = {}"""


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (PIXELS.format("RGB", 0, 0), ""),
        (PIXELS.format("BGR", 0, 0), "takes the pixels as BGR, and they are RGB"),
        (PIXELS.format("RGB", 200, 20), "no colour is found: the lower bound 200 is above 20, the upper one"),
        (PIXELS.format("RGB", 0, 360), "360 bounds nothing: bytes end at 255, and a hue of OpenCV at 179"),
        (PIXELS.format("RGB", 170, 179), ""),
        (CENTRE.format("image.height / 2 - centre[1]"), ""),
        (CENTRE.format("centre[0] - image.width / 2"), ""),
        (
            CENTRE.format("image.height / 2 - centre[0]"),
            "mixes height and column: a centroid is (column, row)",
        ),
        (CENTRE.format("centre[1] - image.width / 2"), "mixes row and width: a centroid is (column, row)"),
        (CENTRE.format("centre[1] / image.width"), ""),  # one scale for both directions
        (SHARE.format("100.0 * found.left"), ""),
        (SHARE.format("found.left"), "'found.left' is a share from 0 to 1, so the rate is at most 1 Hz"),
    ],
)
@pytest.mark.parametrize("guard", ["", "if not isinstance(camera.value, type(None)):\n        "])
def test_images_are_read_as_they_are(husky: Path, body: str, words: str, guard: str) -> None:
    text = guard + (body.replace("\n", "\n    ") if guard else body)
    (husky / "see.py").write_text(SEEN.format(text))
    settings = [f"transfer_functions=[{husky}/see.py, {husky}/listing1.py]"]
    found = _warnings(validate_file(husky / "experiment.yaml", settings))
    assert [words in one for one in found] == [True] * bool(words), found


def test_a_row_is_counted_below_the_question_for_a_message(husky: Path) -> None:
    row = "if not isinstance(camera.value, type(None)):\n        rows.record_entry(t, camera.value.width, 1)"
    text = SEEN.format(f"eye.rate = 1.0\n    {row}").replace("camera, eye)", "camera, eye, rows)")
    text = text.replace(
        "@nrp.Robot2", '@nrp.MapCSVRecorder("rows", "a.csv", headers=["t", "width"])\n@nrp.Robot2'
    )
    (husky / "see.py").write_text(text)
    found = validate_file(
        husky / "experiment.yaml", [f"transfer_functions=[{husky}/see.py, {husky}/listing1.py]"]
    )
    assert any("a row of 3 under 2 headers" in one.message for one in found)


BOTH = "right.rate, left.rate = RATE * felt[angles < -aside].max(), RATE * felt[angles > aside].max()"
RIGHT, LEFT = "RATE * felt[angles < -aside].max()", "RATE * felt[angles > aside].max()"


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (f"right.rate = {RIGHT}\n    left.rate = {LEFT}", []),
        (f"right.rate = {RIGHT}\n    right.rate = {LEFT}",
         ["nothing sets the source 'left'"]),
        (f"right.rate = {RIGHT}\n    right.rate = min(right.rate, 9.0)\n    left.rate = {LEFT}", []),
        (f"right.rate = {RIGHT}\n    if t > 1:\n        right.rate = {LEFT}\n    left.rate = {LEFT}", []),
    ],
)  # fmt: skip
def test_a_source_with_a_weight_that_is_never_set(slalom: Slalom, body: str, words: list[str]) -> None:
    found = [one.message for one in slalom(STEER, BOTH, body) if one.level is not Level.NOTE]
    assert len(found) == len(words), found
    assert all(wanted in one for wanted, one in zip(words, sorted(found, reverse=True), strict=True))
