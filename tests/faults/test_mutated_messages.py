"""Messages changed at random, as bytes and as requests to a running experiment."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mutations import Tally, mutated, numbered, numbers_in

from nrp_core.errors import DivergedError, TopicError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.control import ControlServer
from nrp_core.experiment.running.control_commands import commands_of
from nrp_core.experiment.running.run import Run
from nrp_core.messages.base import Time
from nrp_core.messages.cdr import Codec
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.geometry_msgs import Pose, Twist, Vector3
from nrp_core.messages.nrp_msgs import Spikes
from nrp_core.messages.sensor_msgs import Image, JointState
from nrp_core.messages.std_msgs import Header, String

MESSAGES = (
    Twist(Vector3(0.5, 0.0, 1.0), Vector3(0.0, 0.0, -2.0)),
    String("a text with äöü"),
    ModelStates(["husky", "wall"], [Pose(), Pose()], [Twist(), Twist()]),
    JointState(Header(Time(3, 5), "base"), ["left", "right"], [1.0, 2.0], [3.0, 4.0], []),
    Spikes(Header(Time(1, 2)), "circuit", np.arange(5, dtype=np.uint32), np.arange(5.0)),
    Image(Header(), 2, 3, "rgb8", 0, 9, np.zeros(18, np.uint8)),
)
REQUESTS: tuple[dict[str, Any], ...] = (
    {"command": "publish", "topic": "/husky/cmd_vel", "value": {"linear": {"x": 0.5}, "angular": {"z": 1.0}}},
    {"command": "publish", "topic": "/left_vr_screen/body/screen_glass/color", "value": "Gazebo/RedGlow"},
    {"command": "publish", "topic": "/screens/right/color", "value": [1, 0, 0, 1]},
    {"command": "functions", "add": ["no_file.py"], "remove": [], "activate": ["grab_image"],
     "deactivate": []},
)  # fmt: skip


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_mutated_bytes_are_a_message_or_refused(message: Any) -> None:
    codec = Codec()
    name, sound = codec.name(type(message)), bytes(codec.encode(message))
    tally = Tally(name, lambda error: isinstance(error, TopicError) and name in str(error))
    for number, random in numbered(name):
        data = mutated(sound, random, text=False)
        tally.take(number, lambda data=data: codec.decode(data, name))
    tally.check()


@pytest.fixture
def run() -> Iterator[Run]:
    with Run(load_experiment("braitenberg_husky", ["world.options.image_scale=0.05"])) as run:
        yield run


def step(run: Run) -> None:
    """Take a step; after an absurd command an engine may say that it diverged, and begins anew."""
    try:
        run.step()
    except DivergedError:
        run.loop.reset()


def test_mutated_requests_are_answered_and_the_run_goes_on(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "run.sock"
    answers: dict[bool, int] = {True: 0, False: 0}

    def ask(data: bytes) -> None:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(path))
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            with connection.makefile("rb") as file:
                lines = file.readlines()
        assert len(lines) == sum(1 for line in data.split(b"\n") if line or not data), (data, lines)
        for line in lines:
            answer = json.loads(line)
            answers[answer["ok"]] += 1
            assert answer["ok"] or ("\n" not in answer["error"] and answer["error"]), answer

    tally = Tally("request", lambda error: False)
    with ControlServer(path, commands_of(run)):
        for number, random in numbered("request"):
            data = mutated(json.dumps(random.choice(REQUESTS)).encode(), random, text=True)
            data = b" ".join(line for line in data.splitlines() if line.strip()) or b"{}"
            tally.take(number, lambda data=data: ask(data))
            if number % 10 == 0:
                step(run)
    print(answers)
    tally.check()
    step(run)
    assert all(map(isfinite, numbers_in(run.result().final_pose)))
    assert answers[True]
    assert answers[False]
