"""Slips of Python, of variables, messages and images that run without an error are reported at their line."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Finding, Level

# The comment in a line is the code of its finding and some words of it.
WRONG = """\
import math

import gazebo_msgs.msg
import cv2; import numpy as np
from cv_bridge import CvBridge; from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image, JointState; from std_msgs.msg import ColorRGBA


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapRobotSubscriber("joints", Topic("/husky/joint_states", JointState))
@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("cells", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("rec", nrp.brain.actors, nrp.spike_recorder)
@nrp.MapVariable("count", initial_value=0)
@nrp.MapVariable("total", initial_value=0.0)
@nrp.MapCSVRecorder("rows", "rows.csv", headers=["time", "voltage"])
@nrp.Robot2Neuron()
def see(t, camera, joints, states, eye, left, cells, rec, count, total, rows):
    n = count.value
    n += 1  # NRP330 this changes the copy 'n', and 'count.value' stays as it was
    total.value = 0.0  # NRP330 resets the variable in every call
    total.value += left.voltage
    eye.rate = n + min(left.voltage, left.voltage)  # NRP320 has the same value twice
    eye.rate += left.voltage - left.voltage  # NRP320 it is always 0
    eye.rate += max(0, left.voltage, 1)  # NRP320 only 1 matters
    eye.rate += n ^ 2  # NRP320 a power is written '**'
    if left.voltage < 0.1 and left.voltage > 0.5:  # NRP320 nothing is above 0.5 and below 0.1
        eye.rate = 1.0
    if left.voltage < 0.5 or left.voltage > 0.1:  # NRP320 every value is above 0.1 or below 0.5
        eye.rate = 2.0
    if n != 1 or n != 2:  # NRP320 always true: no value equals both numbers
        eye.rate = 3.0
    if 0.5 < left.voltage < 0.1:  # NRP320 nothing is above 0.5 and below 0.1
        eye.rate = 4.0
    if ~(left.voltage > 0.1):  # NRP320 is -1 or -2, and both count as true: write 'not'
        eye.rate = 5.0
    if left.voltage > -55.0:  # NRP320 is always true: an integrator rests at 0 mV
        eye.rate = 6.0
    if len(rec.times) and t - rec.times[-1][1] < 0.1:  # NRP233 'rec.times' is in ms
        eye.rate = 7.0
    np.clip(left.voltage, 0, 1)  # NRP300 the value of 'np.clip(left.voltage, 0, 1)' is not used
    rng = np.random.default_rng(0)  # NRP320 starts again in every call
    eye.rate += rng.normal() + math.sin(360 * t)  # NRP249 turns by 7.2 rad in a step of 0.02 s
    voltages = (one for one in cells.voltage)  # NRP320 gives its items once, and is empty
    mean = sum(voltages) / 2
    eye.rate += mean + max(voltages, default=0.0)
    rows.record_entry(left.voltage, t)  # NRP254 the time 't' goes below 'voltage', and not below 'time'
    shape = camera.value.width, camera.value.height, 3
    pixels = np.frombuffer(camera.value.data, np.uint8)
    swapped = pixels.reshape(camera.value.width, camera.value.height, 3)  # NRP331 its height comes first
    image = np.frombuffer(camera.value.data, np.uint8).reshape(camera.value.height, camera.value.width, 3)
    red = image[:, :, 0] - image[:, :, 1] > 50  # NRP331 subtracts bytes, and 10 - 20 is then 246
    eye.rate += red.mean() + swapped.mean() + len(shape)
    state = joints.value
    if state is not None:
        state.position[0] = 0.0  # NRP300 is part of a received message: changing it moves nothing
    eye.rate += state.position[state.name.index("left_wheel")]  # NRP332 has no joint 'left_wheel'
    if "front_left_weel" in joints.value.name:  # NRP332 did you mean 'front_left_joint'?
        eye.rate = 8.0
    yaw = states.value.pose[-1].orientation.z  # NRP233 is part of a quaternion, not an angle
    eye.rate += yaw


@nrp.MapVariable("mood", initial_value=0, scope=nrp.GLOBAL)
@nrp.Robot2Neuron()
def decide(t, mood):
    mood.value = 0
    for t in range(3):  # NRP253 this loop overwrites 't', which is used again in line 72
        mood.value += t
    mood.value += t


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("cells", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.leaky_integrator_exp)
@nrp.MapVariable("mood", initial_value=0)  # NRP330 nothing sets this 'mood': another function sets the one
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, left, cells, mood):
    twist = Twist()
    for voltage in cells.voltage:  # NRP320 this loop ends in its first round
        twist.linear.x += voltage
        break
    if left.voltage > mood.value:
        twist.linear.x = 1.0
        return twist
    else:
        twist.linear.x = 0.0  # NRP300 'twist' is filled and not returned here


def shortened(state):
    state.name = state.name[:2]


CUT = nrp.PreprocessedTopic("/husky/joint_states", JointState, shortened)  # NRP300 it is always None

@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapRobotSubscriber("joints", CUT)
@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.MapRobotPublisher("screen", Topic("/left_vr_screen/body/screen_glass/color", ColorRGBA))
@nrp.MapSpikeSource("dc", nrp.brain.sensors[1], nrp.dc_source)
@nrp.MapSpikeSource("ac", nrp.brain.sensors[2], nrp.ac_source)
@nrp.MapSpikeSource("eye", nrp.brain.sensors[3], nrp.poisson)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapSpikeSink("right", nrp.brain.actors[1], nrp.population_rate)
@nrp.MapSpikeSink("rec", nrp.brain.actors, nrp.spike_recorder)
@nrp.MapVariable("seen", initial_value=0)  # NRP330 nothing sets this 'seen': 'tell' sets another of its own
@nrp.Robot2Neuron()
def more(t, camera, joints, states, screen, dc, ac, eye, left, right, rec, seen):
    dc.amplitude = 2e-10 * left.rate  # NRP297 'amplitude' is in nA and is set to 2e-10 or a multiple
    ac.phase = math.pi / 2  # NRP297 half a turn is 180
    ac.frequency = 0.001  # NRP248 0.04 periods in a run of 40 s; is it meant in kHz?
    ac.offset: 0.1  # NRP320 sets nothing: a value is assigned with '='
    if camera.value.width > seen.value:
        eye.rate = 75.0
    if left.rate == right.rate:  # NRP248 compares two measured numbers
        ac.amplitude = 0.1 * np.sin(2 * np.pi * 50 * t)  # NRP249 turns by 6.28 rad in a step
    recent = [one for _, one in rec.times if one > t - 0.1]  # NRP233 'rec.times' is in ms
    pixels = CvBridge().imgmsg_to_cv2(camera.value, "rgb8")
    hsv = cv2.cvtColor(pixels, cv2.COLOR_BGR2HSV)  # NRP331 takes the pixels as BGR, and they are RGB
    states.value.name.sort()  # NRP300 changes the received message
    if type(camera.value) == "Image":  # NRP320 compares a type with a text: they are never equal
        ac.offset = left.rate // 100  # NRP320 rounds down to a whole number; a quotient is written '/'
        ac.offset += np.cos(left.rate * 180 / np.pi)  # NRP249 takes degrees as radians
    screen.send_message(ColorRGBA(len(recent), hsv.mean(), len(joints.value.name)))  # NRP298 is invisible


@nrp.MapVariable("seen", initial_value=0)
@nrp.Robot2Neuron()
def tell(t, seen):
    seen.value = t
"""
WRONG_SOURCES = """\
import math

import numpy as np
from sensor_msgs.msg import Image


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("dc", nrp.brain.sensors[1], nrp.dc_source)
@nrp.MapSpikeSource("ac", nrp.brain.sensors[2], nrp.ac_source, phase=math.pi / 2)  # NRP297 half a turn is 180
@nrp.MapSpikeSource("eye", nrp.brain.sensors[3], nrp.poisson)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.Robot2Neuron()
def once(t, camera, dc, ac, eye, left):
    found = nrp.tf_lib.detect_red(camera.value)
    ac.amplitude = 2e-10  # NRP297 'amplitude' is in nA and is set to 2e-10 or a multiple
    if left.rate > 50:
        dc.amplitude = 0.5  # NRP320 stays at 0.5 nA once it was set
    if 0.3 < found.left:
        eye.rate = 75.0  # NRP320 stays at 75 Hz once it was set
"""
SENT = """\
from geometry_msgs.msg import Twist


@nrp.MapRobotPublisher("commands", Topic("/husky/cmd_vel", Twist))
@nrp.Neuron2Robot()
def drive(t, commands):
    twist = Twist()
    twist.linear.x = 1.0
    commands.send_message(twist)
    twist.linear.x = 2.0  # NRP300 'twist.linear.x' is set after line 9 has sent 'twist'
"""
REMEMBERED = """\
seen = False


@nrp.MapSpikeSource("dc", nrp.brain.sensors[1], nrp.dc_source)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.Robot2Neuron()
def latch(t, dc, left):
    global seen
    if left.rate > 50:
        seen = True  # NRP301 restores 'seen'
        dc.amplitude = 0.5
"""
RIGHT = """\
import math

import gazebo_msgs.msg
import cv2; import numpy as np
from cv_bridge import CvBridge; from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image, JointState; from std_msgs.msg import ColorRGBA

NOISE = np.random.default_rng(3)


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapRobotSubscriber("joints", Topic("/husky/joint_states", JointState))
@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha, v_rest=-60.0)
@nrp.MapSpikeSink("cells", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("rec", nrp.brain.actors, nrp.spike_recorder)
@nrp.MapVariable("count", initial_value=0)
@nrp.MapVariable("total", initial_value=0.0)
@nrp.MapVariable("gain", initial_value=2.0)
@nrp.MapCSVRecorder("rows", "rows.csv", headers=["time", "voltage"])
@nrp.Robot2Neuron()
def see(t, camera, joints, states, eye, left, cells, rec, count, total, gain, rows):
    n = count.value
    n += 1
    count.value = n
    total.value = 0.0 if t < 1 else total.value
    total.value += left.voltage
    factor = gain.value
    eye.rate = factor * n + min(left.voltage, cells.voltage[0]) + max(0, left.voltage) + n**2 + (n ^ 1)
    if 0.1 < left.voltage < 0.5 or left.voltage > 1:
        eye.rate = 1.0
    if left.voltage < 0.1 or left.voltage > 0.5:
        eye.rate = 2.0
    if n != 1 and n != 2:
        eye.rate = 3.0
    if left.voltage > -55.0 and 1000 * t - rec.times[-1][1] < 100:
        eye.rate = 6.0
    image = np.frombuffer(camera.value.data, np.uint8).reshape(camera.value.height, camera.value.width, 3)
    mask = ~(image > 20)
    red = image[:, :, 0].astype(int) - image[:, :, 1] > 50
    pixels = image.astype(float)
    eye.rate = red.mean() + (pixels[:, :, 0] - pixels[:, :, 1]).mean() + mask.mean()
    eye.rate += math.sin(2 * math.pi * t)
    first = (one for one in cells.voltage)
    eye.rate += next(first) + next(first)
    items = (one for one in cells.voltage)
    if n > 3:
        eye.rate = sum(items)
    else:
        eye.rate = max(items)
    rows.record_entry(t, left.voltage)
    state = joints.value
    if state is not None and "front_left_joint" in state.name:
        eye.rate += state.position[state.name.index("front_left_joint")]
    q = states.value.pose[-1].orientation
    yaw = 2 * math.atan2(q.z, q.w)
    for one in cells.voltage:
        if one > yaw:
            continue
        eye.rate += one
        break
    for voltage in cells.voltage:
        eye.rate += voltage
        if voltage > 3:
            break


@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.MapVariable("last")
@nrp.MapVariable("mood", initial_value=0, scope=nrp.GLOBAL)
@nrp.Robot2Neuron()
def decide(t, states, last, mood):
    states.value.pose[-1].position.x = t
    last.value = states.value
    mood.value = t


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapVariable("mood", initial_value=0, scope=nrp.GLOBAL)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, left, mood):
    twist = Twist()
    if left.voltage > mood.value:
        twist.linear.x = 1.0
    else:
        twist.linear.x = 0.0
    return twist


def shortened(state):
    return JointState(name=state.name[:2])

@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapRobotSubscriber("joints", nrp.PreprocessedTopic("/husky/joint_states", JointState, shortened))
@nrp.MapRobotPublisher("screen", Topic("/left_vr_screen/body/screen_glass/color", ColorRGBA))
@nrp.MapSpikeSource("dc", nrp.brain.sensors[1], nrp.dc_source)
@nrp.MapSpikeSource("ac", nrp.brain.sensors[2], nrp.ac_source, phase=90.0)
@nrp.MapSpikeSource("eye", nrp.brain.sensors[3], nrp.poisson)
@nrp.MapSpikeSource("late", nrp.brain.sensors[4], nrp.poisson)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapSpikeSink("rec", nrp.brain.actors, nrp.spike_recorder)
@nrp.MapVariable("seen", initial_value=0)
@nrp.Robot2Neuron()
def more(t, camera, joints, screen, dc, ac, eye, late, left, rec, seen):
    dc.amplitude = 1e-3 * left.rate
    ac.frequency = 5.0
    ac.amplitude = 0.1 * np.sin(2 * np.pi * 5 * t)
    if camera.value.width > seen.value:
        eye.rate = 75.0
    else:
        eye.rate = 0.0
    if t > 2:
        late.rate = 50.0
    if left.rate == 0:
        seen.value += 1
    recent = [one for _, one in rec.times if one > 1000 * t - 100]
    first = cv2.cvtColor(CvBridge().imgmsg_to_cv2(camera.value, "bgr8"), cv2.COLOR_BGR2HSV)
    second = cv2.cvtColor(CvBridge().imgmsg_to_cv2(camera.value), cv2.COLOR_RGB2HSV)
    names = list(joints.value.name)
    names.sort()
    screen.send_message(ColorRGBA(len(recent), first.mean(), second.mean(), len(names)))


@nrp.MapVariable("seen", initial_value=0)
@nrp.Robot2Neuron()
def tell(t, seen):
    seen.value = t
"""
RIGHT_SOURCES = """\
import math

import numpy as np
from sensor_msgs.msg import Image


@nrp.MapSpikeSource("dc", nrp.brain.sensors[0], nrp.dc_source)
@nrp.MapSpikeSource("ac", nrp.brain.sensors[1], nrp.ac_source, phase=math.degrees(math.pi / 90))
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapVariable("first", initial_value=True)
@nrp.Robot2Neuron()
def latch(t, dc, ac, left, first):
    ac.phase = math.degrees(math.pi / 2)
    ac.phase = 0.05 * 180 / math.pi
    ac.phase = left.voltage * 180 / math.pi
    ac.phase = 90 * math.sin(2 * math.pi * t)
    ac.offset = 1e6 * left.voltage * 1e-9
    if first.value and left.voltage > 0.5:
        dc.amplitude = 0.5
        first.value = False


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", Image))
@nrp.MapSpikeSource("dc", nrp.brain.sensors[3], nrp.dc_source)
@nrp.MapSpikeSource("ac", nrp.brain.actors[0], nrp.ac_source)
@nrp.MapSpikeSource("eye", nrp.brain.sensors[4], nrp.poisson)
@nrp.MapSpikeSource("late", nrp.brain.actors[1], nrp.poisson)
@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.Robot2Neuron()
def begin(t, camera, dc, ac, eye, late, left):
    if t > 2 * math.pi:
        late.rate = 30.0
    if camera.value is not None:
        eye.rate = 20.0
        image = np.frombuffer(camera.value.data, np.uint8)
        dc.amplitude = 5e-9 * np.sum(image)
    levels = np.array([0.0, 0.1, 0.2])
    state = int(left.rate // 20)
    ac.amplitude = levels[left.rate // 20] if left.rate // 20 < 2 else 0.1 * state
"""


def found_in(husky: Path, text: str) -> list[Finding]:
    (husky / "slips.py").write_text(text)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky / 'slips.py'}]"])
    assert all(one.path == husky / "slips.py" for one in found), found
    return [one for one in found if one.level is not Level.NOTE]


@pytest.mark.parametrize("code", [WRONG, WRONG_SOURCES, REMEMBERED, SENT])
def test_each_slip_is_reported_once_at_its_line(husky: Path, code: str) -> None:
    found = found_in(husky, code)
    for line, text in enumerate(code.splitlines(), start=1):
        messages = [f"{one.code.name} {one.message}" for one in found if one.line == line]
        _, sign, wanted = text.partition("  # NRP")
        if not sign:
            assert messages == [], text
            continue
        number, _, words = wanted.partition(" ")
        assert len(messages) == 1, (text, messages)
        assert messages[0].startswith(f"NRP{number} "), (text, messages)
        assert words in messages[0], (text, messages)


@pytest.mark.parametrize("code", [RIGHT, RIGHT_SOURCES], ids=["all", "sources"])
def test_code_like_it_that_is_right_is_left_alone(husky: Path, code: str) -> None:
    assert [str(one) for one in found_in(husky, code)] == []


@pytest.mark.parametrize(
    "body",
    [
        "twist.linear.x = 2.0\n    commands.send_message(twist)",
        "commands.send_message(twist)\n    twist.linear.x = 2.0\n    commands.send_message(twist)",
        "last.value = twist\n    commands.send_message(twist)\n    twist.linear.x = 2.0",
        "commands.send_message(twist)\n    twist.linear.x = 2.0\n    last.value = twist.linear.x",
        "commands.send_message(twist)\n    twist = Twist()\n    twist.linear.x = 2.0",
    ],
)
def test_a_message_that_is_used_again_may_change_after_it_was_sent(husky: Path, body: str) -> None:
    code = SENT.replace("drive(t, commands)", "drive(t, commands, last)")
    head, _, _ = code.replace("@nrp.Map", '@nrp.MapVariable("last", initial_value=0)\n@nrp.Map', 1).partition(
        "    twist.linear.x = 1.0"
    )
    assert [one.message for one in found_in(husky, f"{head}    {body}\n") if one.code is Code.NRP300] == []
