"""Mistakes in places, times, surroundings and units are reported, and correct variants are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.checks.warnings import with_warnings
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import Code, InvalidExperimentError, Level

HEAD = """\
import os
import subprocess
import threading
import urllib.request

import geometry_msgs.msg
import std_msgs.msg


@nrp.MapSpikeSource("red", nrp.brain.sensors{neurons}, nrp.{device})
@nrp.MapCSVRecorder("rows", "{file}", headers=["t", "{header}"])
{mapped}@nrp.Robot2Neuron()
def see(t, red, rows{taken}):
    red.rate = 1.0
    rows.record_entry(t, t)
    {body}


@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t):
    return geometry_msgs.msg.Twist()
"""

OWN = "@nrp.MapRobotPublisher('topic', Topic('/mine', std_msgs.msg.Float64))\n"
SEND = "topic.send_message(std_msgs.msg.Float64(t))"


def said(husky: Path, *overrides: str) -> list[str]:
    """Return the errors and warnings about an experiment."""
    found = validate_file(husky / "experiment.yaml", overrides)
    return [str(finding) for finding in found if finding.level is not Level.NOTE]


def of_functions(husky: Path, body: str = "pass", **changes: str) -> list[str]:
    given = {"device": "poisson", "header": "x", "neurons": "[0]", "file": "rows.csv"} | changes
    given |= {"mapped": OWN, "taken": ", topic"} if "topic" in body else {"mapped": "", "taken": ""}
    (husky / "mine.py").write_text(HEAD.format(body=body, **given))
    functions = f"transfer_functions=[{husky}/mine.py]"
    return said(husky, functions, *(["topics={/mine: std_msgs/Float64}"] if "send" in body else []))


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("criteria.reaches_left.within_of.time=15 min", "allows 900 s, and the run lasts 40 s [NRP248]"),
        ("world.options.timestep=20 ms", "the physics step is 20 ms, and 1 to 5 ms are usual: contacts"),
        ("world.options.timestep=2 us", "10000 steps of 0.002 ms in each step of the loop"),
        ("brain.interventions=[{scale: {sources: sensors, by: 50}}]", "by 50; is it in percent? [NRP297]"),
        (
            "brain.controls=[{shuffle: weights}, {shuffle: weights}]",
            "controls: items 0 and 1 of the list are the same",
        ),
        ("criteria.reaches_left.near.model=left_vr_screen", "'left_vr_screen' is always near itself"),
        ("brain.populations.more=[0, 0, 1]", "the population 'more' has 2 neurons, some of them twice"),
        (
            "world.robots.husky.add_sensors=[{type: imu, link: base_link, pose: [0, 0, 0, 0, 30, 0]}]",
            "the pitch of the sensor on 'husky/base_link' is 30 rad, more than a turn; 30 degrees are 0.5236",
        ),
        (
            "world.robots.husky.add_sensors=[{type: lidar, link: base_link, lidar: {scan: {horizontal: "
            "{samples: 1, min_angle: -1.5, max_angle: 1.5}}}}]",
            "a laser with one ray has angles from -1.5 to 1.5 rad: the ray points to the first",
        ),
        ("world.sensors={/husky/camera: {}}", "sets nothing; valid: noise, bias, delay, drop_out"),
        (f"csv_folder={__file__}", "test_round.py' is a file, and the files of recorders need a folder"),
        ("events.left_red.at=40 s", "'left_red' is at 40 s, and the run ends at 40 s [NRP248]"),
        (
            "brain.interventions=[{silence: actors}, {silence: actors}]",
            "interventions: items 0 and 1 of the list are the same",
        ),
        ("world.robots.husky.joints={front_left_joint: 1 m}", "takes angles, not '1 m' [NRP209]"),
    ],
)
def test_settings_of_an_experiment_without_effect_are_reported(
    husky: Path, override: str, words: str
) -> None:
    assert any(words in message for message in said(husky, override))


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    "override",
    [
        "criteria.reaches_left.within_of.time=20 ms",
        "criteria.reaches_right.near.within=5 m",
        "criteria.reaches_left.near.within=2.5 m",
        "world.options.timestep=10 ms",
        "criteria.x={near: {model: husky, point: [6, 4], within: 1 m}}",
        "criteria.x={near: {model: husky, point: [7.5, 0], within: 1 m}}",
        "events.again={at: 5 s, publish: {topic: /screens/left/color, value: Gazebo/RedGlow}}",
        "brain.populations.more=[0, 1]",
        "world.sensors={/husky/camera: {noise: 0.02}}",
        "criteria.x={topic_stays: {name: /husky/odom, field: twist.twist.linear.x, equals: 0}}",
        "world.sensors={/husky/camera: {noise: 0.5, bias: -0.2}}",
        "events.go={when: {near: {model: left_vr_screen, other: husky, within: 1 m}}}",
        "topics={/mine: std_msgs/Float64}",
        "criteria.x={stays_within: {model: husky, distance: 9 m, of: [3, 0]}}",
        "criteria.x={stays_within: {model: husky, distance: 1 m, of: [3, 0], during: {since: 9 s}}}",
        "events.left_red.publish={topic: /screens/left/color, value: {r: 1, a: 1}}",
        "events.home={when: {event: all_blue, near: {model: husky, point: [0, 0], within: 1 m}}}",
        "world.robots.husky.add_sensors=[{type: imu, link: base_link, pose: [0, 0, 0, 0, 30 deg, 0]}]",
    ],
)
def test_settings_of_an_experiment_with_effect_are_not_reported(husky: Path, override: str) -> None:
    assert said(husky, override) == []


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    "body",
    [
        "print(os.path.join('a', 'b'))",
        "threading = 3; print(threading)",
        "try:\n        print(1 / t)\n    except ZeroDivisionError:\n        pass",
        "try:\n        print(1 / t)\n    except Exception as error:\n        print(error)",
        "red.rate = 100.0 * (t > 1)",
        "red.rate = 100.0 if t > 1 else 0.0",
        "x = 0\n    for i in range(5):\n        x = x + i\n    print(x)",
        "x = [t] * 5\n    for i in range(5):\n        x[i] = t + i\n    print(x)",
        "x = 0\n    for i in range(5):\n        x = i\n        if i > t:\n            break\n    print(x)",
        "import numpy as np; red.rate = 100.0 * (np.array([t, 1.0])[:1].min() > 0.5)",
        "red = None if t > 1 else red\n    if red is None:\n        return",
        f"if t > 1:\n        {SEND}\n        return\n    {SEND}",
    ],
)
def test_values_used_within_a_function_are_not_reported(husky: Path, body: str) -> None:
    assert of_functions(husky, body) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"device": "poisson, weight=150.0"}, "weight of 'red' is 150 uS or nA; is it"),
        ({"device": "poisson, weight=-0.01"}, "the conductances of 'circuit' are never negative"),
        ({"neurons": "[[0, 0]]"}, "'red' drives the same neuron 2 times: brain.sensors[[0, 0]] [NRP211]"),
        ({"neurons": "[0, 0:2]"}, "'red' drives the same neuron 2 times"),
        ({"file": "/tmp/rows.csv"}, "'/tmp/rows.csv' is outside the folder of the run"),
    ],
)
def test_settings_in_a_wrong_unit_are_reported(husky: Path, changes: dict[str, str], words: str) -> None:
    assert any(words in message for message in of_functions(husky, **changes))


def test_a_weight_beyond_both_limits_is_reported_once(husky: Path) -> None:
    assert len([one for one in of_functions(husky, device="poisson, weight=150.0") if "NRP297" in one]) == 1


def test_a_tag_in_a_yaml_file_is_refused_with_its_line(husky: Path) -> None:
    path = husky / "experiment.yaml"
    path.write_text(path.read_text().replace("seed: 7", "seed: !env SEED"))
    (message,) = said(husky)
    assert "experiment.yaml:8:7: the tag '!env' has no meaning here" in message


JOINT = ("husky.sdf", "<axis><xyz>0 1 0</xyz></axis>", "<axis><xyz>0 1 0</xyz>{}</axis>")
RATE = ("husky.sdf", "<update_rate>30<", "<update_rate>{}<")
LIMITS = "<limit><lower>-{0}</lower><upper>{0}</upper></limit>"
FILES = [
    (JOINT, LIMITS.format(1), "'back_left_joint' is continuous: it turns past its <limit> of -1 to 1 rad"),
    (JOINT, LIMITS.format(3.14159), ""),
    (JOINT, LIMITS.format(1e16), ""),
    (RATE, "1000", ""),
    (RATE, "0.5", ""),
]  # fmt: skip


@pytest.mark.one_of(2)
@pytest.mark.parametrize(("edit", "value", "words"), FILES, ids=lambda one: str(one)[-12:])
def test_a_value_of_a_file_is_reported_if_it_cannot_be_meant(
    husky: Path, edit: tuple[str, str, str], value: str, words: str
) -> None:
    name, old, new = edit
    path = husky / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new.format(value), 1))
    found = [str(one) for one in validate_file(husky / "experiment.yaml") if one.code is not Code.NRP238]
    assert [words in message for message in found] == [True] * bool(words)


def test_a_room_that_is_the_robot_is_refused_with_both_names(husky: Path) -> None:
    (message,) = said(husky, f"world.scene={husky}/husky.sdf")
    assert "the room already has a model 'husky': rename the robot, or the model" in message
    assert "; for a robot in the scene's file leave 'model' out [NRP209]" in message


def test_a_run_reports_devices_and_parameters_without_effect(husky: Path) -> None:
    (husky / "mine.py").write_text(
        "@nrp.MapSpikeSource('red', nrp.brain.sensors[0, 0], nrp.poisson)\n"
        "@nrp.Robot2Neuron()\ndef see(t, red):\n    red.rate = 1.0\n"
        "gain = nrp.parameter('gain', 1.0)\n"
    )
    plan = prepare(load_experiment(husky, [f"transfer_functions=[{husky}/mine.py]"]))
    found = {(one.code.name, one.line) for one in with_warnings(plan).warnings}
    assert found >= {("NRP211", 1), ("NRP279", 5)}


@pytest.mark.parametrize("name", ["../rows.csv", "/tmp/rows.csv", "a/../../rows.csv"])
def test_a_run_refuses_rows_outside_its_folder(husky: Path, name: str) -> None:
    (husky / "mine.py").write_text(
        f"@nrp.MapCSVRecorder('rows', {name!r}, headers=['t'])\n"
        "@nrp.Neuron2Robot()\ndef log(t, rows):\n    pass\n"
    )
    with pytest.raises(InvalidExperimentError) as error:
        prepare(load_experiment(husky, [f"transfer_functions=[{husky}/mine.py]"]))
    errors = [one for one in error.value.findings if one.level is Level.ERROR]
    assert [(one.code, one.line) for one in errors] == [(Code.NRP210, 1)]


def test_a_setting_for_a_file_of_functions_alone_is_reported(husky: Path) -> None:
    said_of_it = [str(one) for one in validate_file(husky / "listing1.py", ["seed=3"])]
    assert any("'seed=3' has no effect on a file of functions alone" in one for one in said_of_it)
    assert not any("has no effect" in str(one) for one in validate_file(husky / "listing1.py"))


def test_a_topic_of_two_parts_is_one_error_with_its_place(husky: Path) -> None:
    path = husky / "husky.sdf"
    path.write_text(path.read_text().replace("<odometryTopic>odom<", "<odometryTopic>cmd_vel<"))
    (error,) = [one for one in validate_file(husky / "experiment.yaml") if one.level is Level.ERROR]
    assert error.message.startswith("two parts of the scene have the topic '/husky/cmd_vel'")
    assert (error.path, error.line) == (husky / "experiment.yaml", 19)
