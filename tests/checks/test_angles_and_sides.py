"""Angles in another unit, rounded commands, lost values and exchanged sides are reported at their line."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

HEAD = """\
import math

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Float64
"""
# The comment in a line is the code of its finding and some words of it.
WRONG = f"""{HEAD}


@nrp.MapRobotSubscriber("odom", Topic("/husky/odom", Odometry))
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapVariable("last", initial_value=0.0)
@nrp.MapVariable("pan", initial_value=0.0)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, odom, left, last, pan):
    q = odom.value.pose.pose.orientation
    yaw = 2 * math.atan2(q.z, q.w)
    if abs(yaw) < 90:  # NRP249 the angle is in radians and never 90; 90 degrees are 1.571
        return Twist()
    if q.z > 1.5:  # NRP248 'q.z' is a part of a quaternion, from -1 to 1, never 1.5
        return Twist()
    heading = 2 * math.atan2(q.w, q.z)  # NRP249 half the angle is atan2(z, w)
    if t % 2:  # NRP320 asks whether a remainder of seconds is exactly 0
        return Twist()
    last.value = t
    step = t - last.value  # NRP320 is always 0: line 26 has set it to 't'
    pan.value =+ step * left.rate  # NRP320 sets 'pan.value' to +step * left.rate; '+=' adds to it
    pan.value =- left.rate * 2  # NRP320 sets 'pan.value' to -left.rate * 2; '-=' subtracts
    speed = left.rate * 0.1 + math.radians(heading - yaw)  # NRP249 takes an angle in radians as degrees
    turn = pan.value * 57.3
    forward = Vector3(round(speed), 0, 0)  # NRP320 'round(speed)' is a whole number of m/s or rad/s
    return Twist(forward, Vector3(0, 0, turn))  # NRP249 'pan.value * 57.3' is in degrees


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("left_eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSource("right_eye", nrp.brain.sensors[1], nrp.poisson)
@nrp.MapSpikeSource("green", nrp.brain.sensors[4], nrp.poisson, weight=50.0)  # NRP297 2e+04 times the leak
@nrp.Robot2Neuron()
def see(t, camera, left_eye, right_eye, green):
    found = nrp.tf_lib.detect_red(camera.value)
    left_eye.rate = 1000.0 * found.left
    right_eye.rate = 1000.0 * found.left  # NRP320 is one of them of the other side?
    green.rate = 75.0 * found.go_on * np.cos(np.arange(4) - 2).max()  # NRP249 takes 0, 1, 2, ... as radians
    green.rate = 75.0  # NRP320 this replaces 'green.rate' of line 45
"""
WRONG_STEPS = f"""{HEAD}
DT = 0.2
SENT = Twist()


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapVariable("pan", initial_value=0.0)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, left, pan):
    pan.value += DT * left.rate  # NRP320 'DT' is 0.2, and the function runs every 0.02 s
    SENT.linear.x += left.rate  # NRP301 no reset and no snapshot restores 'SENT'
    turning = Twist()
    turning.angular.z = pan.value * 180 / 3.1416  # NRP249 is in degrees, and messages carry radians
    if t > 3:
        return turning
    SENT.linear.y = np.float64(left.rate).clip(1, 0)  # NRP320 is always 0: its lower limit, 1, is above
    SENT.angular = Vector3(0, 0, 180 / math.pi * pan.value)  # NRP249 is in degrees
    return SENT


@nrp.MapRobotSubscriber("scan", Topic("/husky/scan", LaserScan))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.Robot2Neuron()
def feel(t, scan, eye):
    names = [one + "_joint" for one in ("left", "left")]  # NRP320 goes 2 times over 'left' alone
    ranges = np.maximum(scan.value.ranges, scan.value.range_max)  # NRP320 is the minimum meant?
    eye.rate = len(names) + ranges.mean()
"""
WRONG_ROWS = f"""{HEAD}

@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapSpikeSink("right", nrp.brain.actors[1], nrp.population_rate)
@nrp.MapVariable("begun", initial_value=False)
@nrp.MapVariable("before", initial_value=0.0)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def steer(t, left, right, begun, before):
    turn, step = (right.rate - left.rate) * 180 / np.pi, t - before.value
    if not begun:  # NRP320 'begun' is a variable, not a value; did you mean 'begun.value'?
        return Twist(Vector3(step))
    before = t  # NRP242 this replaces the parameter and sets nothing: the value of 'before' is never used
    speed = 0.1 * (left.rate + right.rate) // 2  # NRP320 a whole number of m/s or rad/s; a quotient is
    return Twist(Vector3(speed), Vector3(0, 0, turn))  # NRP249 is in degrees, and messages carry radians
"""
RIGHT = f"""{HEAD}
DT = 0.02
dt = 0.1
TIME_STEP = 0.1
DELTA_T = 0.001
SENT = Twist()


class Sun:
    brightness = 5.0


def euler_from_quaternion(wxyz):
    w, x, y, z = wxyz
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


@nrp.MapRobotSubscriber("odom", Topic("/husky/odom", Odometry))
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapVariable("last", initial_value=0.0)
@nrp.MapVariable("pan", initial_value=0.0)
@nrp.MapRobotPublisher("told", Topic("/shown_deg", Float64))
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, odom, left, last, pan, told):
    q = odom.value.pose.pose.orientation
    yaw = 2 * math.atan2(q.z, q.w)
    degrees = math.degrees(yaw)
    if abs(degrees) < 90 and abs(yaw) < 3 and -0.5 < q.z < 0.7 or (q.z + q.w) * 3 > 1.5:
        return Twist()
    if t % 2 < 1 and (t % 4) * 2 > 1:
        return Twist()
    step, last.value = t - last.value, t
    pan.value += step * left.rate * DT
    pan.value = -left.rate
    pan.value = - step
    pan.value = +step
    count = int(left.rate) + int(yaw > 0)
    moving = int(left.rate > 3)
    turn = math.radians(degrees) + pan.value * 57.0
    SENT.linear = Vector3(moving) if t < 1 else Vector3(int(moving), 0, math.degrees(yaw) * 0.01)
    SENT.angular = Vector3(0, 0, 0.02 * yaw * 57.3)
    SENT.angular.z = turn + count * 0.1 * round(left.rate, 3)
    speed = Vector3()
    speed.x += np.float64(left.rate).clip(0, 1)
    SENT.linear.x = speed.x
    SENT.linear.x += euler_from_quaternion([q.w, q.x, q.y, q.z])
    counted = yaw + 2 * math.pi * pan.value
    if counted > 20:
        pan.value =-(left.rate + yaw)
    told.send_message(Float64(degrees))
    return SENT


@nrp.MapRobotSubscriber("odom", Topic("/husky/odom", Odometry))
@nrp.MapVariable("last", initial_value=0.0)
@nrp.MapVariable("way", initial_value=0.0)
@nrp.MapRobotPublisher("told", Topic("/way", Float64))
@nrp.MapSpikeSink("cells", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.population_rate)
@nrp.Neuron2Robot()
def rarely(t, odom, last, way, told, cells):
    last.value, gear = last.value, 0.1 * (cells.rate[0] // 10)
    first, *others = cells.rate
    speed = Vector3(gear, sum(others) - first)
    odom_then = odom.value
    odom = odom_then
    if odom and not last.value and cells:
        way.value += speed.x
    for _ in range(int(0.02 / DELTA_T)):
        way.value += DELTA_T * (1 - way.value)
    if t - last.value < TIME_STEP:
        return
    last.value = t
    way.value += TIME_STEP * odom.twist.twist.linear.x
    told.send_message(Float64(way.value))


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapRobotPublisher("told", Topic("/heading_deg", Float64))
@nrp.Neuron2Robot()
def tell(t, left, told):
    turned = 0.0
    for name in ("left", "right", "left"):
        turned += len(name)
    for _ in range(5):
        turned += dt * left.rate
    told.send_message(Float64(round(turned * 57.3)))


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("left_eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSource("right_eye", nrp.brain.sensors[1], nrp.poisson)
@nrp.MapSpikeSource("both", nrp.brain.sensors[2:4], nrp.poisson, weight=0.1)
@nrp.MapRobotSubscriber("scan", Topic("/husky/scan", LaserScan))
@nrp.MapSpikeSource("green", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron()
def see(t, camera, scan, left_eye, right_eye, both, green):
    found = nrp.tf_lib.detect_red(camera.value)
    left_eye.rate = 1000.0 * found.left
    right_eye.rate = 1000.0 * found.right
    if t > 9:
        left_eye.rate = 1000.0 * found.right
        right_eye.rate = 1000.0 * found.left
    if t > 11:
        ranges = scan.value.ranges
        left_eye.rate = ranges[80:100].min()
        right_eye.rate = ranges[80:100].min()
        left_eye.rate += ranges[ranges > 0.1].min()
        right_eye.rate = ranges[ranges > 0.1].min()
    both.rate = 1000.0 * found.left
    if t > 7:
        left_eye.rate = t * Sun.brightness
        right_eye.rate = t * Sun.brightness
    green.rate = 75.0 * found.go_on * np.cos(0.1 * np.arange(4)).max()
    if t > 5:
        green.rate = 75.0
    if camera.value is None:
        left_eye.rate = 100.0 * math.hypot(t, 1)
        right_eye.rate = 100.0 * math.hypot(t, 1)
"""


def found_in(husky: Path, text: str) -> list[Finding]:
    (husky / "mine.py").write_text(text)
    numbers = "".join(f"/{name}: std_msgs/Float64, " for name in ("heading_deg", "shown_deg", "way"))
    topics = f"topics={{{numbers}/husky/scan: sensor_msgs/LaserScan}}"
    overrides = [f"transfer_functions=[{husky / 'mine.py'}]", topics]
    found = validate_file(husky / "experiment.yaml", overrides)
    return [one for one in found if one.level is not Level.NOTE]


@pytest.mark.parametrize("code", [WRONG, WRONG_STEPS, WRONG_ROWS], ids=["all", "steps", "rows"])
def test_each_slip_is_reported_once_at_its_line(husky: Path, code: str) -> None:
    found = found_in(husky, code)
    for line, text in enumerate(code.splitlines(), start=1):
        messages = [f"{one.code.name} {one.message}" for one in found if one.line == line]
        _, sign, wanted = text.partition("  # NRP")
        number, _, words = wanted.partition(" ")
        assert len(messages) == bool(sign), (text, messages)
        assert all(one.startswith(f"NRP{number} ") and words in one for one in messages), (text, messages)


def test_code_like_it_that_is_right_is_left_alone(husky: Path) -> None:
    assert [str(one) for one in found_in(husky, RIGHT)] == []
