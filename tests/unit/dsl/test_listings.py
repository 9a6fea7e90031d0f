"""The listings of the paper, character for character, do what the paper says.

The texts below are those of the printed page, with its line numbers.
"""

from __future__ import annotations

import re
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import numpy as np
import pytest

from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.loading import load_transfer_functions
from nrp_core.dsl.testing import MockBrain, MockWorld, Rig
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.sensor_msgs import Image

FOLDER = Path(experiment.__file__).parent

LISTING_1 = """\
1 import hbp_nrp_client.tf_framework as nrp
2 import geometry_msgs.msg
3
4 @nrp.MapSpikeSink("left_wheel_neuron", nrp.brain.actors[0], nrp.
   leaky_integrator_alpha)
5 @nrp.MapSpikeSink("right_wheel_neuron", nrp.brain.actors[1], nrp.
   leaky_integrator_alpha)
6 @nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))
7 def linear_twist(t, left_wheel_neuron, right_wheel_neuron):
8     linear = geometry_msgs.msg.Vector3(20 * min(left_wheel_neuron.
9         voltage, right_wheel_neuron.voltage), 0, 0)
9     angular = geometry_msgs.msg.Vector3(0, 0, 100 * (right_wheel_neuron
10        .voltage - left_wheel_neuron.voltage))
11     return geometry_msgs.msg.Twist(linear=linear, angular=angular)
"""

LISTING_2 = """\
1 @nrp.MapRobotSubscriber("camera", Topic('/husky/camera', sensor_msgs.
  msg.Image))
2 @nrp.MapSpikeSource("red_left_eye", nrp.brain.sensors[0, 2], nrp.
  poisson)
3 @nrp.MapSpikeSource("red_right_eye", nrp.brain.sensors[1, 3], nrp.
  poisson)
4 @nrp.MapSpikeSource("green_blue_eye", nrp.brain.sensors[4], nrp.
  poisson)
5 @nrp.Robot2Neuron()
6 def eye_sensor_transmit(t, camera, red_left_eye, red_right_eye,
  green_blue_eye):
7     image_results = nrp.tf_lib.detect_red(camera.value)
8
9     red_left_eye.rate = 1000.0 * image_results.leftred
10    red_right_eye.rate = 1000.0 * image_results.rightred
11    green_blue_eye.rate = 1000.0 * image_results.greenblue
"""


def without_numbers(printed: str) -> str:
    """Take the number column off: the digits and one space, which two digits may have swallowed."""
    number = re.compile(r"^\d++(?: (?! {3}\S))?", re.MULTILINE)
    return number.sub("", printed)


def load(name: str) -> dict[str, TransferFunction]:
    return {function.name: function for function in load_transfer_functions(FOLDER / name)}


def paper_brain() -> MockBrain:
    return MockBrain({"sensors": 5, "between": 1, "actors": 2})


def platform_brain() -> MockBrain:
    return MockBrain({"sensors": 5, "actors": 3})


def robot() -> MockWorld:
    return MockWorld({"/husky/camera": Image, "/husky/cmd_vel": Twist})


def image(left: int = 0, right: int = 0) -> Image:
    """A grey image with so many red columns in its halves."""
    pixels = np.full((240, 320, 3), 128, np.uint8)
    pixels[:, :left] = pixels[:, 320 - right : 320] = (255, 0, 0)
    return Image(height=240, width=320, encoding="rgb8", step=960, data=pixels)


@pytest.mark.parametrize(("name", "printed"), [("listing1.py", LISTING_1), ("listing2.py", LISTING_2)])
def test_the_files_are_the_printed_text(name: str, printed: str) -> None:
    assert (FOLDER / name).read_text() == without_numbers(printed)


@pytest.mark.parametrize(
    ("left_mv", "right_mv", "linear", "angular"),
    [(0.5, 0.25, 5.0, -25.0), (0.0, 0.0, 0.0, 0.0), (0.25, 0.5, 5.0, 25.0)],
)
def test_listing_1_turns_voltages_into_a_twist(
    left_mv: float, right_mv: float, linear: float, angular: float
) -> None:
    rig = Rig(load("listing1.py")["linear_twist"], paper_brain(), robot())
    rig.set(left_wheel_neuron=left_mv, right_wheel_neuron=right_mv)
    rig.run()
    assert rig.sent("/husky/cmd_vel") == [Twist(Vector3(linear, 0, 0), Vector3(0, 0, angular))]


@pytest.mark.parametrize(
    ("left", "right", "rates"), [(0, 0, (0, 0, 1000)), (160, 0, (1000, 0, 500)), (0, 40, (0, 250, 875))]
)
def test_listing_2_turns_red_into_rates(left: int, right: int, rates: tuple[float, float, float]) -> None:
    function = load("listing2.py")["eye_sensor_transmit"]
    rig = Rig(function, paper_brain(), robot())
    rig.set(camera=image(left, right))
    rig.run()
    assert (function.red_left_eye.rate, function.red_right_eye.rate, function.green_blue_eye.rate) == rates


def test_listing_2_sees_nothing_before_the_first_image() -> None:
    function = load("listing2.py")["eye_sensor_transmit"]
    Rig(function, paper_brain(), robot()).run()
    assert function.green_blue_eye.rate == 0.0


def test_the_connected_devices_are_accessed_by_the_function_s_name() -> None:
    functions = {**load("listing1.py"), **load("listing2.py")}
    Rig(functions["linear_twist"], paper_brain(), robot())
    Rig(functions["eye_sensor_transmit"], paper_brain(), robot())
    assert functions["linear_twist"].left_wheel_neuron.port.neurons.tolist() == [6]
    assert functions["linear_twist"].right_wheel_neuron.port.neurons.tolist() == [7]
    assert functions["eye_sensor_transmit"].red_left_eye.port.neurons.tolist() == [0, 2]
    assert functions["eye_sensor_transmit"].red_right_eye.port.neurons.tolist() == [1, 3]
    assert functions["eye_sensor_transmit"].green_blue_eye.port.neurons.tolist() == [4]


def test_the_platform_s_own_gains_choose_the_same_neurons() -> None:
    functions = load("nrp_gains.py")
    drive = Rig(functions["linear_twist"], platform_brain(), robot())
    drive.set(left_wheel_neuron=0.5, right_wheel_neuron=0.25)
    drive.run()
    assert drive.sent("/husky/cmd_vel") == [Twist(Vector3(5.0, 0, 0), Vector3(0, 0, -25.0))]
    eyes = functions["eye_sensor_transmit"]
    see = Rig(eyes, platform_brain(), robot())
    see.set(camera=image(left=80))
    see.run()
    assert (eyes.red_left_eye.rate, eyes.red_right_eye.rate, eyes.green_blue_eye.rate) == (1000, 0, 56.25)
    assert eyes.red_left_eye.port.neurons.tolist() == [0, 2]
    assert eyes.red_right_eye.port.neurons.tolist() == [1, 3]
    assert functions["linear_twist"].left_wheel_neuron.port.neurons.tolist() == [6]
    assert functions["linear_twist"].right_wheel_neuron.port.neurons.tolist() == [7]
