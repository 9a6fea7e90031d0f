"""A misspelt name is reported with the name to put in its place, and doing so mends the experiment."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding

SCRIPT = """\
import geometry_msgs.msg
import sensor_msgs.msg
from math import fabs


@nrp.MapRobotSubscriber("image", Topic("/husky/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("red", nrp.brain.sensors[0], nrp.poisson, weight=0.5)
@nrp.Robot2Neuron()
def see(t, image, red):
    red.rate = fabs(t) + image.value.height


@nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, wheel):
    twist = geometry_msgs.msg.Twist()
    twist.linear.x = wheel.voltage
    return twist
"""


def findings(husky: Path, text: str) -> list[Finding]:
    (husky / "mine.py").write_text(text)
    return validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/mine.py]"])


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("red.rate", "red.rates"),
        ("wheel.voltage", "wheel.voltag"),
        ("image.value.height", "image.value.heigth"),
        ("twist.linear.x", "twist.liner.x"),
        ("/husky/camera", "/husky/camara"),
        ("nrp.brain.sensors", "nrp.brain.sensor"),
        ('MapSpikeSource("red"', 'MapSpikeSource("rad"'),
        ("weight=0.5", "weigth=0.5"),
        ("geometry_msgs.msg.Twist()", "geometry_msgs.msg.Twits()"),
        ("return twist", "return twits"),
    ],
)
def test_the_name_that_was_meant_mends_the_line(right: str, wrong: str, husky: Path):
    text = SCRIPT.replace(right, wrong, 1)
    of_file = [one for one in findings(husky, text) if one.path == husky / "mine.py"]
    (finding,) = {(one.line, one.column, one.instead) for one in of_file if one.instead is not None}
    line, column, (written, meant) = finding
    lines = text.splitlines(keepends=True)
    before, after = lines[line - 1][: (column or 1) - 1], lines[line - 1][(column or 1) - 1 :]
    lines[line - 1] = before + re.sub(rf"(?<![\w/]){re.escape(written)}(?![\w/])", meant, after, count=1)
    assert "".join(lines) == SCRIPT
    assert f"'{meant}'" in next(one.message for one in of_file if one.instead)


def test_a_name_like_no_other_is_not_replaced(husky: Path):
    found = findings(husky, SCRIPT.replace("red.rate", "red.qqq", 1))
    assert {one.instead for one in found if one.path == husky / "mine.py"} == {None}
