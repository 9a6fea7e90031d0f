"""Bodies of transfer functions: what is said of them, and of what nothing is said because it works."""

from __future__ import annotations

import ast
import sysconfig
from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.checks.code.body import FunctionBody
from nrp_core.checks.code.declarations import Declared
from nrp_core.checks.code.imports import Imports
from nrp_core.checks.validate import validate_file
from nrp_core.dsl.functions import Robot2Neuron
from nrp_core.dsl.loading import python_listing
from nrp_core.findings import Finding

HEAD = """\
import math

import geometry_msgs.msg
import numpy as np

GAINS = {"left": 2.0}
N = 3
ROBOT = "husky"


def helper(x, *more):
    return x


@nrp.MapRobotSubscriber("camera", Topic(f"/{ROBOT}/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("eyes", nrp.map_neurons(range(N), lambda i: nrp.brain.sensors[i]), nrp.poisson)
@nrp.MapSpikeSource("noise", nrp.brain.sensors[4], nrp.nc_source, stdev=0.1)
@nrp.MapSpikeSink("wheels", nrp.chain_neurons(nrp.brain.actors[0], nrp.brain.actors[1]), nrp.population_rate)
@nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("spikes", nrp.brain.actors, nrp.spike_recorder)
@nrp.MapVariable("count", initial_value=np.zeros(3), scope=nrp.GLOBAL)
@nrp.MapCSVRecorder("rows", "rows.csv", ["Time", "Rate"])
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, camera, eyes, noise, wheels, wheel, spikes, count, rows):
    used = (camera, eyes, noise, wheels, wheel, spikes, count, rows)
    eyes.rate = 0.0
"""
TAIL = "    return geometry_msgs.msg.Twist() if used else None\n"

Check = Callable[[str], list[Finding]]


@pytest.fixture
def check(husky: Path, functions: Path) -> Check:
    """Return a function that gives all findings about a body but the latency of the loop."""

    def checked(body: str) -> list[Finding]:
        lines = "".join(f"    {line}\n" for line in body.splitlines())
        (husky / "drive.py").write_text(HEAD + lines + TAIL)
        found = validate_file(functions, [f"transfer_functions=[{husky}/drive.py]"])
        return [finding for finding in found if finding.code.name != "NRP238"]

    return checked


WORKS = [
    "eyes.rate = 2.0 * wheels.rate[0]",
    "for eye, rate in zip(eyes, (1.0, 2.0, 3.0)):\n    eye.rate = rate",
    "eyes.rate = [1.0, 2.0, 3.0]",
    "eyes[0].rate = 5.0\neyes[1:].rate = 6.0\neyes[-1].active = False",
    "noise.mean, noise.stdev = 0.1, 0.2",
    "rows.record_entry(t, wheel.voltage, *wheels.rate)",
    "count.value[0] += 1\ncount.value = count.value + 1",
    "if camera.changed and camera.value is not None:\n"
    "    eyes.rate = camera.value.width + camera.value.header.stamp.sec",
    "camera = camera.value\neyes.rate = camera.width",
    "n = len(eyes) + len(spikes.times)\neyes.rate = [helper(i) for i in range(n)][0]",
    "wheel = wheel.voltage\neyes.rate = helper(wheel, 1, 2)",
    "try:\n    eyes.rate = wheel.rate\nexcept AttributeError:\n    eyes.rate = 0.0",
    "if hasattr(wheel, 'rate'):\n    eyes.rate = wheel.rate",
    "share = 0\nfor time in spikes.times:\n    share += time[1]\neyes.rate = 1.0 / share if share else 0.0",
    "n = 0\nwhile n < 3:\n    n += 1\neyes.rate = 10.0 / n",
    "n = 0\nif camera.changed:\n    n = 2\neyes.rate = 10.0 / n if n else 0.0",
    "result = nrp.tf_lib.detect_red(camera.value)\neyes.rate = 10.0 * max(result.left, result.rightred)",
    "found = [one for one in wheels.rate if one > 1.0]\neyes.rate = float(len(found)) * math.pi",
    "eyes.rate = np.clip(wheel.voltage, 0.0, 1.0).item()",
    "twist = geometry_msgs.msg.Twist()\ntwist.linear.x = 2 * wheel.voltage\n"
    "twist.angular = geometry_msgs.msg.Vector3(z=1)\nhelper(twist)",
    "def scaled(x):\n    return x / GAINS['left']\neyes.rate = scaled(2.0)",
    "eyes.rate = (lambda x: x.anything)(helper(count))",
    "with np.errstate(all='ignore'):\n    eyes.rate = abs(t)",
    "match helper(t):\n    case 1:\n        eyes.rate = 1.0\n    case other:\n        eyes.rate = other",
    "import os.path\neyes.rate = float(os.path.exists('x'))",
    "assert (rate := 3.0) > 0\neyes.rate = rate",
    "eyes.rate = '%d' % 0 and 1.0",
    "helper(camera, wheel, eyes)\nprint(camera, wheel)\neyes.rate = min(eyes, key=lambda eye: eye.rate).rate",
    "while True:\n    if t > 1.0:\n        break\n    t += 1.0",
    "while 1:\n    for rate in wheels.rate:\n        if rate:\n            break\n    else:\n        break",
    "def forever():\n    while True:\n        yield 1\neyes.rate = next(forever())",
    "if t < 39.9 and t * 1000 < 1e6:\n    eyes.rate = 1.0",
    "if camera.value is None or wheel == 3 or not count:\n    eyes.rate = 1.0",
    "import random\neyes.rate = random.Random(t).random()",
    "eyes.rate = float(np.sum(wheels.rate)) + sum(count.value)",
]


@pytest.mark.parametrize("body", WORKS)
def test_valid_code_yields_no_finding(check: Check, body: str) -> None:
    assert [str(finding) for finding in check(body)] == []


FAILS = [
    ("eyes.rat = 1.0", "NRP240"),
    ("eyes.rate = [1.0, 2.0]", "NRP240"),
    ("for eye in eyes:\n    eye.voltage = 1.0", "NRP240"),
    ("eyes[1].rate = -1.0", "NRP240"),
    ("noise.stdev = -0.1", "NRP240"),
    ("helper(wheels.voltage)", "NRP240"),
    ("spikes.times = 1", "NRP240"),
    ("camera.value = None", "NRP240"),
    ("helper(camera.value.header.stamp.hours)", "NRP240"),
    ("twist = geometry_msgs.msg.Twist()\ntwist.linaer.x = 1.0\nhelper(twist)", "NRP240"),
    ("twist = geometry_msgs.msg.Twist()\ntwist.linear = 1.0\nhelper(twist)", "NRP240"),
    ("if t > 1:\n    return wheel.voltage", "NRP240"),
    ("rows.record(t)", "NRP240"),
    ("count.vale = 1", "NRP240"),
    ("helper(math.squrt(2))", "NRP240"),
    ("helper(np.maen([1]))", "NRP240"),
    ("helper(np.random.rand())", "NRP243"),
    ("nrp.tf_lib.detect_red(camera.value, 3)", "NRP240"),
    ("eyes.rate = wheel", "NRP240"),
    ("eyes.rate = camera.value", "NRP240"),
    ("eyes.rate = [1.0, nrp.tf_lib.detect_red(camera.value), 2.0]", "NRP240"),
    ("helper(2 * wheel)", "NRP240"),
    ("helper(wheel > 2)", "NRP240"),
    ("helper(-camera.value)", "NRP240"),
    ("helper(min(wheel, 3.0))", "NRP240"),
    ("nrp.tf_lib.detect_red(camera)", "NRP240"),
    ("count += 1", "NRP240"),
    ("helper(wheel.voltage())", "NRP240"),
    ("helper(eyes(0))", "NRP240"),
    ("if t > 5000:\n    helper(t)", "NRP248"),
    ("if 41 <= t:\n    helper(t)", "NRP248"),
    ("import time\ntime.sleep(1)", "NRP357"),
    ("from random import random\nhelper(random())", "NRP243"),
    ("helper(eyes[3].rate)", "NRP240"),
    ("helper(wheel[0])", "NRP240"),
    ("helper(wheel.voltage[0])", "NRP240"),
    ("for x in camera:\n    helper(x)", "NRP240"),
    ("eyes.rate = [t, helper(t)]", "NRP240"),
    ("helper(len(spikes))", "NRP240"),
    ("print('t: ' + t)", "NRP240"),
    ("helper(abs(t, 1))", "NRP240"),
    ("if t > 1:\n    return geometry_msgs.msg.Twist", "NRP240"),
    ("noise.mean = None", "NRP240"),
    ("helper(t.value)", "NRP240"),
    ("twist = geometry_msgs.msg.Twist()\ntwist.linear = [1, 2, 3]\nhelper(twist)", "NRP240"),
    ("helper(wheels.rate * 2.0)", "NRP240"),
    ("helper(eyes > 3)", "NRP240"),
    ("helper()", "NRP240"),
    ("helper(math.sqrt(t, 2))", "NRP240"),
    ("rows.record_entry(t)", "NRP240"),
    ("count = helper(count.value)\ncount.value += 1", "NRP253"),
    ("helper(wheal.voltage)", "NRP246"),
]


@pytest.mark.parametrize(("body", "code"), FAILS)
def test_failing_code_is_reported_at_its_place(check: Check, body: str, code: str) -> None:
    found = check(body)
    assert [finding.code.name for finding in found] == [code], found
    assert found[0].line is not None
    assert found[0].line > HEAD.count("\n")
    assert found[0].column


def test_any_python_can_be_walked_through() -> None:
    count = 0
    for path in sorted(Path(sysconfig.get_paths()["stdlib"]).glob("*.py"))[::8]:
        listing = python_listing(path)
        (source,) = listing.sources
        for node in ast.walk(source.tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                function = Robot2Neuron()(lambda t: None)
                imports = Imports(listing, lambda _: {})
                body = FunctionBody(Declared(function, node, source, {}, {}, imports), {})
                for one in body.nodes:
                    body.shape(one)
                count += 1
    assert count > 100
