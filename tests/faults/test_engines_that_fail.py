"""A process that is killed, a disk that is full, NaN: one clear error, and what was recorded can be read."""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
from dataclasses import fields, is_dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from mutations import numbers_in
from nrp_brain_event import EventBackend

from nrp_core.brain.devices.sources import ACSource, DCSource, NoisyCurrentSource
from nrp_core.brain.devices.trains import FixedFrequencySource, PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.brain.remote import RemoteBrain
from nrp_core.errors import SimulationError, TopicError, TransferFunctionRaisedError
from nrp_core.experiment.making.plan import Plan, Side
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.network.data import Network
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.reading.recover import recover
from nrp_core.recording.recording import Recording
from nrp_core.world.topics import Direction

SMALL = ("world.options.image_scale=0.1", "duration=2 s", "criteria=null")
STATES = "/gazebo/model_states"


def steps_in(folder: Path) -> int:
    """Return how many steps a recording holds."""
    return sum(1 for _ in Recording(folder).messages({STATES})) - 1


# -- processes


class ElsewhereBackend(EventBackend):
    """The event brain in a process of its own."""

    def open(self, network: Network, *, seed: int, options: Any) -> Brain:
        return RemoteBrain(EventBackend(), network, seed=seed, options=options, python=sys.executable)


def elsewhere(plan: Plan) -> Plan:
    side = plan.brain
    return replace(plan, brain=Side(ElsewhereBackend(), side.options, side.capabilities))


@pytest.mark.parametrize(
    ("moment", "on_error"), [("between two steps", "stop"), ("while it runs", "quarantine")]
)
def test_a_brain_process_that_is_killed_is_one_error_and_the_recording_is_complete(
    on_error: str, moment: str, tmp_path: Path, golden: Golden
) -> None:
    folder = tmp_path / "recording"
    with Run(load_experiment("braitenberg_husky", [*SMALL, f"on_error={on_error}"]), revise=elsewhere) as run:
        recording_folder = RecordingFolder(run, folder)
        process = run.brain._process  # type: ignore[attr-defined]

        def kill(*_: object) -> None:
            if run.loop.now_ns == 200_000_000:
                os.kill(process.pid, signal.SIGKILL)

        hooks = run.loop.hooks
        (hooks.after_step if moment == "between two steps" else hooks.before_step).append(kill)
        with golden.raises(SimulationError, match="SIGKILL"):
            run.run()
        recording_folder.close("failed")
        assert "SIGKILL" in str(run.result().error)
        assert run.loop.failures == []
    recording = Recording(folder)
    assert recording.complete
    assert recording.run["state"] == "failed"
    assert steps_in(folder) == 10


# -- the disk

SMALLEST, LARGEST = 3_000, 120_000
SIZES = SMALLEST, pytest.param(40_000, marks=pytest.mark.heavy), LARGEST
"""Of the largest file that may be written: too small for the experiment, for the first steps, for more."""


@pytest.fixture(scope="module")
def _compiled() -> None:
    """Let code be compiled and kept before the disk is full."""
    with Run(load_experiment("braitenberg_husky", SMALL)) as run:
        run.run_until(0.4)


@pytest.mark.one_of(3)
@pytest.mark.usefixtures("_compiled")
@pytest.mark.parametrize("size", SIZES)
def test_a_disk_that_is_full_is_one_error_and_what_was_recorded_can_be_read(
    size: int, tmp_path: Path
) -> None:
    folder = tmp_path / "recording"
    command = [
        *(sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--record", str(folder), "--json"),
        *("-s", "world.options.image_scale=0.1", "-s", "pace=20", "--until", "15s"),
    ]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=300,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stderr
    error = json.loads(done.stdout)["error"]
    assert error["message"].startswith("the recording cannot be "), error
    assert error["message"].endswith("File too large"), error
    if size == SMALLEST:
        return  # not even the experiment could be kept
    steps = json.loads(done.stdout)["steps"]
    recording = Recording(folder)
    kept = steps_in(folder)
    assert 0 <= kept <= steps
    recovered = recover(recording, tmp_path / "recovered.mcap")
    assert recovered.messages == sum(1 for _ in recording.raw())
    if size == LARGEST:  # the reserve is too small for what a slow machine has not written yet
        assert kept == steps if recording.complete else kept > 0


# -- NaN

SENDS = """
import math


@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def sends(t, eye):
    if t > 0.05:
        {what}
"""
NANS = {
    "a message": "return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(math.nan, 0, 0))",
    "an infinite message": "return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(0, 0, math.inf))",
    "a rate": "eye.rate = math.nan",
}
ENGINES = [("event", "mujoco"), ("spinnaker", "pybullet")]


@pytest.fixture(params=ENGINES, ids="-".join)
def engines(request: pytest.FixtureRequest) -> tuple[str, ...]:
    brain, world = request.param
    return (*SMALL, f"brain.backend={brain}", f"world.backend={world}")


@pytest.mark.parametrize("what", NANS)
def test_nan_from_a_function_is_refused_where_it_is_sent(
    engines: tuple[str, ...], what: str, tmp_path: Path, golden: Golden
) -> None:
    path = tmp_path / "sends.py"
    path.write_text(SENDS.format(what=NANS[what]))
    settings = [*engines, f"transfer_functions=[{path}]"]
    with Run(load_experiment("braitenberg_husky", settings)) as run:
        with golden.raises(TransferFunctionRaisedError):
            run.run()
        assert run.loop.steps == 3
    with Run(load_experiment("braitenberg_husky", [*settings, "on_error=quarantine"])) as run:
        run.run_until(0.4)
        assert len(run.loop.failures) == 1
        assert "nan" not in str(run.result().final_pose).lower()


def test_nan_from_outside_is_refused_and_the_run_goes_on(engines: tuple[str, ...]) -> None:
    digests = []
    for disturbed in (False, True):
        with Run(load_experiment("braitenberg_husky", engines)) as run:
            run.run_until(0.2)
            if disturbed:
                for wrong in (
                    Twist(Vector3(float("nan"))),
                    Twist(Vector3(float("inf"))),
                    {"linear": {"x": "nan"}},
                ):
                    with pytest.raises(TopicError, match="/husky/cmd_vel"):
                        run.publish("/husky/cmd_vel", wrong)
            run.run_until(0.4)
            digests.append(run.result().trajectory_digest)
    assert digests[0] == digests[1]


def with_nan(message: Any) -> bool:
    """Put NaN into every number of a message that can hold it; return whether there is one."""
    found = False
    for item in fields(message):
        value = getattr(message, item.name)
        if isinstance(value, float):
            setattr(message, item.name, float("nan"))
            found = True
        elif is_dataclass(value):
            found = with_nan(value) or found
    return found


def test_nan_is_refused_by_every_topic_that_takes_numbers(engines: tuple[str, ...]) -> None:
    with Run(load_experiment("braitenberg_husky", engines)) as run:
        run.run_until(0.1)
        refused = set()
        for name, topic in run.world.topics.items():
            if Direction.IN in topic.direction and with_nan(message := topic.type()):
                with pytest.raises(TopicError, match=re.escape(name)):
                    run.world.advertise(name).publish(message)
                refused.add(name)
        run.run_until(0.2)
        assert {"/husky/cmd_vel", "/left_vr_screen/body/screen_glass/color"} <= refused
        assert all(map(isfinite, numbers_in(run.result().final_pose)))


@pytest.mark.parametrize(
    ("source", "setting"),
    [
        (PoissonSource(), "rate"), (FixedFrequencySource(), "rate"), (DCSource(), "amplitude"),
        (ACSource(), "amplitude"), (ACSource(), "frequency"), (NoisyCurrentSource(), "mean"),
        (NoisyCurrentSource(), "stdev"),
    ],
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)  # fmt: skip
def test_nan_is_refused_by_every_device(
    engines: tuple[str, ...], source: Any, setting: str, golden: Golden
) -> None:
    with Run(load_experiment("braitenberg_husky", engines)) as run:
        port = run.brain.add_source(source, [0, 1], name="wrong")
        before = getattr(port, setting)
        for wrong in (float("nan"), float("inf"), [1.0, float("nan")]):
            with golden.raises(ValueError):
                setattr(port, setting, wrong)
        assert getattr(port, setting) == before
        run.run_until(0.1)
