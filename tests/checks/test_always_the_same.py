"""Code that looks as if it decided, counted or commanded something, and does not, is reported at its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

# The comment in a line is the code of its finding and some words of it.
WRONG = """\
import math
from math import sin

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image
from std_msgs.msg import Float64

LATE = 0.05
RED = (200, 0, 0), (220, 255, 255)
RATIO = 1 // 10  # NRP320 '1 // 10' is 0
GAIN = 0.02 // len(RED)  # NRP320 '0.02 // len(RED)' is 0 for a divisor above 0.02
LEVEL = np.cos(90)  # NRP249 'np.cos(90)' takes 90 as radians, more than a turn


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSink("spikes", nrp.brain.actors[0], nrp.spike_recorder)
@nrp.MapVariable("n", initial_value=0.0)
@nrp.MapVariable("speed", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.MapCSVRecorder("rows", "rows.csv", headers=["t", "n"])
@nrp.Robot2Neuron()
def see(t, camera, eye, spikes, n, speed, rows):
    speed.value = t
    found = nrp.tf_lib.detect_red(camera.value)
    eye.rate = 1000.0 * found.left
    rows.record_entry(t, n.value)
    if found.left == 0 or 1:  # NRP320 did you mean 'found.left == 0 or found.left == 1'?
        eye.rate = 0.0
    if camera.value.encoding == "rgb8" or "bgr8":  # NRP320 is always true, because of 'bgr8'
        eye.rate = 1.0
    if t > 1:
        eye.rate = 1.0
    elif t > 2:
        eye.rate = 2.0
    elif t > 1:  # NRP320 't > 1' is already tested in line 32
        eye.rate = 3.0
    n.value =+ 1.0  # NRP320 '=+' sets 'n.value' to +1.0; '+=' adds to it
    if found.left > 50:  # NRP248 'found.left' is a share from 0 to 1
        eye.rate = 4.0
    if t == LATE:  # NRP248 't' never equals 0.05: it is a multiple of 0.02 s
        eye.rate = 5.0
    if t == 0:  # NRP248 the first step ends at that time
        eye.rate = 6.0
    if t % 0.1 == 0:  # NRP248 because numbers are rounded
        eye.rate = 7.0
    if len(spikes.times) and t - spikes.times[-1] < 0.1:  # NRP233 'spikes.times' is in ms
        eye.rate = 8.0
    gains = [lambda x: x * i for i in range(3)]  # NRP320 all these functions use the last 'i'
    eye.rate = gains[0](1.0)
    eye.rate += sin(90) + np.cos(180.0)  # NRP249 more than a turn
    if found.left > found.left:  # NRP320 compares a value with itself: it is always False
        eye.rate = 9.0
    eye.rate = np.clip(found.left, 1.0, -1.0)  # NRP320 is always -1: its lower limit, 1, is above
    eye.rate = min(0.5, max(1.0, found.left))  # NRP320 is always 0.5
    eye.rate = 0 * found.right  # NRP320 '0 * found.right' is always 0
    for i in range(3, 0):  # NRP320 this loop never runs: 'range(3, 0)' is empty
        eye.rate = 3.0
    eye.rate = eye.rate  # NRP300 'eye.rate' is set to itself
    abs(found.left)  # NRP300 the value of 'abs(found.left)' is not used
    if int(t * 1000) % 30 == 7:  # NRP248 'int(t * 1000) % 30 == 7' is true at none of the 2000 steps
        eye.rate = 1.0
    if abs(t - LATE) < 0.005 and n.value > 0:  # NRP248 'abs(t - LATE) < 0.005' is true at none
        eye.rate = 2.0
    if t == "0.04":  # NRP248 't == '0.04'' compares a number with a text
        eye.rate = 1.0
    eye.rate = LATE if found.left else LATE  # NRP320 both branches of 'found.left' do the same
    eye.rate = round(LATE) * found.left  # NRP320 'round(LATE)' is always 0: it rounds 0.05
    from math import tan as slope

    eye.rate += slope(45)  # NRP249 'slope(45)' takes 45 as radians
    eye.rate = 3 * (found.left and found.right)  # NRP320 'found.left and found.right' in a computation is one
    eye.rate = math.cos(np.degrees(found.left))  # NRP249 takes degrees as radians
    nrp.tf_lib.find_centroid_hsv(camera.value, (9, 99, 9), (9, 9, 9))  # NRP320 lower saturation, 99, is above
    nrp.tf_lib.find_centroid_hsv(camera.value, *RED)  # NRP320 hue is 0 to 179, not 200 to 220
    low = np.array([2 * 90 + 20, 50, 50])
    nrp.tf_lib.find_centroid_hsv(camera.value, low, [220, 255, 255])  # NRP320 hue is 0 to 179, not 200 to 220
    eye.rate = np.clip(0.0, LATE, found.left)  # NRP320 limits the number 0: the value comes first
    eye.rate = min(1.0, t / 1000)  # NRP233 in s, so that 't / 1000' is at most 0.04 in this run
    while math.floor(1000 * t) > 50_000:  # NRP248 'math.floor(1000 * t) > 50000' is true at none
        eye.rate = 3.0


@nrp.MapRobotPublisher("speeds", Topic("/mine", Twist))
@nrp.MapSpikeSource("late", nrp.brain.sensors[1], nrp.poisson, delay=0.001)  # NRP297 is it meant in s?
@nrp.MapSpikeSink("rate", nrp.brain.actors, nrp.population_rate, tau_fall=0.1)  # NRP297 has forgotten
@nrp.Robot2Neuron()
def send(t, speeds, late, rate):
    late.rate = rate.rate
    for one in (1, 2):
        speeds.send_message(Twist())  # NRP319 many messages on '/mine': functions and robots use


@nrp.MapSpikeSource("seldom", nrp.brain.sensors[2], nrp.fixed_frequency)
@nrp.MapSpikeSource("each", nrp.map_neurons(2, lambda i: nrp.brain.sensors[3]), nrp.poisson)  # NRP320 same
@nrp.MapSpikeSink("v", nrp.brain.actors, nrp.voltage_recorder, dt=0.0001)  # NRP297 dt of 'v' is 0.0001 ms
@nrp.MapRobotPublisher("is_late", Topic("/late", Float64))
@nrp.Robot2Neuron()
def count(t, seldom, each, v, is_late):
    seldom.rate = 0.02  # NRP248 a rate of 0.02 Hz makes hardly one spike in a run of 40 s
    each.rate = v.values.mean()
    is_late.send_message(Float64(v.values.mean() > 1))  # NRP227 'v.values.mean() > 1' is true or false


@nrp.MapCSVRecorder("rows", "rows.csv", headers=["x"])  # NRP254 have the columns x, and go below
@nrp.MapVariable("sped", initial_value=0.0, scope=nrp.GLOBAL)  # NRP210 nothing sets the shared variable
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, rows, sped):
    rows.record_entry(sped.value)
    angular = Vector3(0.3 * t, 0, 1.0)  # NRP321 'angular.x' of the command has no effect
    command = Twist(Vector3(x=t, y=0.5), angular)  # NRP321 'linear.y'
    command.linear.z = 1.0  # NRP321 'linear.z'
    if t > 2:
        return Twist(angular=Vector3(z=math.degrees(t)))  # NRP249 is in degrees, and messages carry radians
    return command
    command.linear.x = 0.0  # NRP320 this is never reached: line 115 returns
"""
RIGHT = """\
import math

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image
from std_msgs.msg import Bool, Float64

RATIO = 10 // 3 + 0 // 7 + 2.5 // 1
LEVEL = math.cos(math.pi / 2) + math.sin(6.2)


def events():
    return
    yield


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSink("spikes", nrp.brain.actors[0], nrp.spike_recorder)
@nrp.MapVariable("n", initial_value=0.0)
@nrp.MapVariable("speed", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.MapCSVRecorder("rows", "rows.csv", headers=["t"])
@nrp.Robot2Neuron()
def see(t, camera, eye, spikes, n, speed, rows):
    found = nrp.tf_lib.detect_red(camera.value)
    rows.record_entry(t)
    name = camera.value.encoding or "rgb8"
    if found.left == 0 or found.right == 0 or name == "mono8":
        eye.rate = 0.0
    if t > 1:
        eye.rate = 1.0
    elif t > 2:
        eye.rate = 2.0
    if t > 1:
        eye.rate = 3.0
    n.value = -1.0
    n.value =-1.0
    n.value = +1.0
    if 0.5 < found.left <= 1:
        eye.rate = 4.0
    if t == 0.06 or t % 1.0 == 0 or t % 0.5 == 0.1:
        eye.rate = 5.0
    if len(spikes.times) and 1000.0 * t - spikes.times[-1] < 100.0:
        eye.rate = 8.0
    gains = [lambda x, i=i: x * i for i in range(3)]
    eye.rate = gains[0](1.0) + speed.value
    eye.rate += math.sin(math.radians(90)) + math.cos(math.pi) + math.sqrt(90)
    if found.left != found.left or found.left > found.right:
        eye.rate = 9.0
    eye.rate = min(1.0, max(0.0, found.left)) + max(0.0, min(1.0, 0.5 * found.right)) + len([0] * 3)
    for i in range(3, 0, -1):
        eye.rate = float(i)
    nrp.tf_lib.find_centroid_hsv(camera.value, (170, 30, 30), (179, 255, 255))
    low = [200 // 2, 50, 50]
    high = (low[0], 255, 255)
    nrp.tf_lib.find_centroid_hsv(camera.value, low, np.array([120 + 10, 255, 255]))
    nrp.tf_lib.find_centroid_hsv(camera.value, low, high)
    low = (int(t), 0, 0)
    eye.rate = round(2.7) + (found.left and 1 / found.left) + math.cos(math.radians(30))
    eye.rate = 1.0 if found.left else 0.0
    moment = t - 0.03
    if int(t * 1000) % 40 == 20 or moment == 0.5 or abs(t - 5.01) < 0.011 or math.sin(t) > 0.9:
        eye.rate = 6.0
    if 1 / (t - 0.02) > 100 or t + n.value > 90:
        eye.rate = 7.0
    try:
        float(name)
    except ValueError:
        eye.rate = speed.value


@nrp.MapSpikeSource("seldom", nrp.brain.sensors[2], nrp.fixed_frequency)
@nrp.MapSpikeSource("each", nrp.map_neurons(2, lambda i: nrp.brain.sensors[3 + i]), nrp.poisson)
@nrp.MapSpikeSink("v", nrp.brain.actors, nrp.voltage_recorder, dt=0.1)
@nrp.MapRobotPublisher("is_late", Topic("/late", Float64))
@nrp.MapRobotPublisher("whether", Topic("/whether", Bool))
@nrp.Robot2Neuron()
def count(t, seldom, each, v, is_late, whether):
    seldom.rate = 0.05 if t > 1 else 20.0
    if t > 3:
        seldom.rate = 0.001
    each.rate = np.clip(v.values.mean(), 0.0, 100 * t) + 1000 * t / 100
    is_late.send_message(Float64(1.0 if t > 1 else 0.0))
    whether.send_message(Bool(t > 1))


@nrp.MapCSVRecorder("rows", "rows.csv", headers=["t"])
@nrp.MapVariable("speed", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, rows, speed):
    rows.record_entry(t)
    speed.value = t
    if t < 1:
        return Twist(angular=Vector3(z=math.radians(30)))
    command = Twist(Vector3(t, 0, 0.0), Vector3(z=t))
    command.angular.x = 0
    return command
"""


def warnings(husky: Path, text: str, *settings: str) -> list[Finding]:
    (husky / "mine.py").write_text(text)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/mine.py]", *settings])
    return [one for one in found if one.level is not Level.NOTE]


def test_each_slip_is_reported_at_its_line(husky: Path) -> None:
    found = warnings(husky, WRONG, "topics={/mine: geometry_msgs/Twist, /late: std_msgs/Float64}")
    lines = WRONG.splitlines()
    expected = {
        number: line.partition("# NRP")[2] for number, line in enumerate(lines, start=1) if "# NRP" in line
    }
    for number, words in expected.items():
        code, _, words = words.partition(" ")
        said = [one for one in found if one.line == number]
        assert {one.code.name for one in said} == {f"NRP{code}"}, lines[number - 1]
        assert all(words in one.message for one in said), said
    assert {one.line for one in found} == set(expected)


def test_code_like_it_that_works_is_not_reported(husky: Path) -> None:
    topics = "topics={/late: std_msgs/Float64, /whether: std_msgs/Bool}"
    assert warnings(husky, RIGHT, topics) == []


LOOP = """\
def renamed(name):
    def rename(function):
        function.__name__ = name
        return function
    return rename


for number, name in enumerate(("left", "right")):
    cells = slice(number, number + 1)

    @nrp.MapSpikeSource("eye", nrp.brain.sensors[cells], nrp.poisson)
    @nrp.Robot2Neuron()
    @renamed(name)
    def see(t, eye):
        eye.rate = {rate}
"""


@pytest.mark.parametrize(("rate", "late"), [("10.0 * number", ["number"]), ("10.0", [])])
def test_functions_of_a_loop_that_use_its_variable_are_reported(
    husky: Path, rate: str, late: list[str]
) -> None:
    found = [one for one in warnings(husky, LOOP.format(rate=rate)) if one.code.name == "NRP320"]
    assert [(one.message.split("'")[1], one.line) for one in found] == [(name, 15) for name in late]


@pytest.mark.parametrize(("half", "is_ignored"), [("linear: {y: 1}", True), ("linear: {x: 1, y: 0}", False)])
def test_an_event_with_a_velocity_that_the_drive_ignores_is_reported(
    husky: Path, half: str, is_ignored: bool
) -> None:
    event = f"events.go={{at: 1 s, publish: {{topic: /husky/cmd_vel, value: {{{half}}}}}}}"
    said = [one.message for one in validate_file(husky / "experiment.yaml", [event, "transfer_functions=[]"])]
    assert any("'linear.y' of the command has no effect" in one for one in said) == is_ignored
