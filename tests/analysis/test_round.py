"""Mistakes in places, times, surroundings and units are reported, and correct variants are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.analysis.validate import validate_file
from nrp_core.findings import Level

HEAD = """\
import os
import subprocess
import threading
import urllib.request

import geometry_msgs.msg


@nrp.MapSpikeSource("red", nrp.brain.sensors[0], nrp.{device})
@nrp.MapCSVRecorder("rows", "rows.csv", headers=["t", "{header}"])
@nrp.Robot2Neuron()
def see(t, red, rows):
    red.rate = 1.0
    rows.record_entry(t, t)
    {body}


@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t):
    return geometry_msgs.msg.Twist()
"""


def said(husky: Path, *overrides: str) -> list[str]:
    """Return the errors and warnings about an experiment."""
    found = validate_file(husky / "experiment.yaml", overrides)
    return [str(finding) for finding in found if finding.level is not Level.NOTE]


def of_functions(
    husky: Path, body: str = "pass", device: str = "poisson", header: str = "x", extra: str = ""
) -> list[str]:
    (husky / "mine.py").write_text(HEAD.format(body=body, device=device, header=header))
    return said(husky, f"transfer_functions=[{husky}/mine.py]", *([extra] if extra else []))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("criteria.reaches_left.within_of.time=15 ms", "a step of 20 ms apart, and the limit is 15 ms"),
        ("criteria.x={near: {model: husky, point: [1000, 0], within: 1 m}}", "'point' is 993 m outside"),
        ("criteria.reaches_left.near.model=left_vr_screen", "'left_vr_screen' is always near itself"),
        ("brain.populations.more=[0, 0, 1]", "the population 'more' has 2 neurons, some of them twice"),
        ("world.sensors={/husky/camera: {}}", "sets nothing; valid: noise, bias, delay, drop_out"),
        (
            "events.blue={at: 5 s, publish: {topic: /left_vr_screen/body/screen_glass/color, value: blue}}",
            "at 5 s, when 'left_red' publishes another value",
        ),
        (
            "events.go={at: 1 s, publish: {topic: /husky/cmd_vel, value: {linear: {x: 1}}}}",
            "'go' publishes on '/husky/cmd_vel', as 'linear_twist' does in every step",
        ),
    ],
)
def test_what_an_experiment_asks_in_vain_is_reported(husky: Path, override: str, words: str) -> None:
    assert any(words in message for message in said(husky, override))


@pytest.mark.parametrize(
    "override",
    [
        "criteria.reaches_left.within_of.time=20 ms",
        "criteria.x={near: {model: husky, point: [6, 4], within: 1 m}}",
        "criteria.x={near: {model: husky, point: [7.5, 0], within: 1 m}}",
        "events.again={at: 5 s, publish: {topic: /screens/left/color, value: Gazebo/RedGlow}}",
        "brain.populations.more=[0, 1]",
        "world.sensors={/husky/camera: {noise: 0.02}}",
    ],
)
def test_what_an_experiment_may_ask_is_not_reported(husky: Path, override: str) -> None:
    assert said(husky, override) == []


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("print(os.environ['RATE'])", "'os.environ' reads a variable of the machine"),
        ("threading.Thread(target=print).start()", "'threading.Thread' runs beside the loop"),
        ("subprocess.run(['ls'])", "'subprocess.run' runs beside the loop"),
        ("urllib.request.urlopen('http://localhost')", "'urllib.request.urlopen' uses the network"),
        ("nrp.parameter('gain', 1.0)", "a parameter is declared at the top of its file"),
        ("try:\n        print(rows.nothing)\n    except Exception:\n        pass", "this drops every error"),
    ],
)
def test_what_a_body_takes_from_elsewhere_is_reported(husky: Path, body: str, words: str) -> None:
    (message,) = of_functions(husky, body)
    assert words in message
    assert "mine.py:1" in message


@pytest.mark.parametrize(
    "body",
    [
        "print(os.path.join('a', 'b'))",
        "threading = 3; print(threading)",
        "try:\n        print(1 / t)\n    except ZeroDivisionError:\n        pass",
        "try:\n        print(1 / t)\n    except Exception as error:\n        print(error)",
    ],
)
def test_what_stays_in_the_body_is_not_reported(husky: Path, body: str) -> None:
    assert of_functions(husky, body) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"device": "poisson, weight=150.0"}, "weight of 'red' is 150 uS or nA; is it meant in nS or pA?"),
        ({"device": "poisson, delay=50000.0"}, "'red' delivers no spike before 50000 ms"),
        ({"device": "injector", "body": "red.inject_spikes([0], [1e9])"}, "a spike at 1e+09 ms is not sent"),
        (
            {"device": "dc_source", "body": "red.amplitude = 500.0"},
            "'amplitude' is 500 nA; is it meant in pA",
        ),
        ({"header": "t"}, "two columns have the header 't'"),
    ],
)
def test_settings_in_a_wrong_unit_are_reported(husky: Path, changes: dict[str, str], words: str) -> None:
    assert any(words in message for message in of_functions(husky, **changes))


def test_a_tag_in_a_yaml_file_is_refused_with_its_line(husky: Path) -> None:
    path = husky / "experiment.yaml"
    path.write_text(path.read_text().replace("seed: 7", "seed: !env SEED"))
    (message,) = said(husky)
    assert "experiment.yaml:8:7: the tag '!env' has no meaning here" in message


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("numpy.random.default_rng()", 1),
        ("numpy.random.seed()", 1),
        ("numpy.random.default_rng(3)", 0),
        ("numpy.random.rand()", 0),
    ],
)
def test_a_brain_script_without_a_seed_is_reported(husky: Path, line: str, found: int) -> None:
    path = husky / "brain.py"
    path.write_text(f"import numpy\n{line}\n{path.read_text()}")
    messages = said(husky)
    assert ["brain.py:2:1" in one and "has no seed" in one for one in messages] == [True] * found


def test_an_own_topic_that_nobody_uses_is_noted(husky: Path) -> None:
    found = validate_file(husky / "experiment.yaml", ["topics={/mine: std_msgs/Float64}"])
    assert any("nothing publishes on the topic '/mine' and nothing reads it" in one.message for one in found)
