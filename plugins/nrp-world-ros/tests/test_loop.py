"""The main experiment with its body in one process and its brain in another, and ROS between them."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest

from conftest import Ros, needs_ros

pytestmark = [needs_ros, pytest.mark.slow]

RUN = (sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--json")
SOON = ("-s", "events.left_red.at=1 s")
"""Both screens are reached before 9 s."""


def result(ros: Ros, *arguments: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(ros.run(*RUN, *arguments, timeout_s=300))
    return found


def test_in_lockstep_a_run_through_ros_is_bit_for_bit_the_run_in_one_process(ros: Ros) -> None:
    ros.body("--lockstep")
    apart = result(
        ros, "--world", "ros", "-s", "world.options={time: lockstep}", *SOON, "-s", "duration=10 s"
    )
    together = result(ros, "-s", "world.options.image_scale=0.25", *SOON, "-s", "duration=10 s")
    assert apart["passed"]
    # the digest of the trajectory is also of joints, which do not pass through ROS here
    assert apart["final_pose"] == together["final_pose"]
    assert apart["spikes"] == together["spikes"]
    # this body stops at steps of the loop only, so an event has the time of the next one
    assert apart["events"] == pytest.approx(together["events"], abs=0.02)


def test_by_the_clock_of_a_simulator_that_does_not_wait_the_experiment_passes(ros: Ros) -> None:
    ros.body("--pace", "realtime")
    found = result(ros, "--world", "ros", *SOON, "-s", "duration=24 s")
    assert found["passed"], found["criteria"]
    assert found["wall_time_s"] > 23


RESET = """
from nrp_core import load_experiment
from nrp_core import Run

settings = ["world.backend=ros", "world.options={time: lockstep}"]
with Run(load_experiment("braitenberg_husky", settings)) as run:
    run.run_until(0.5)
    before = run.result().final_pose["husky"]["yaw"]
    run.loop.reset()
    assert run.now_s == 0.0
    assert run.result().final_pose["husky"]["yaw"] == before
    run.run_until(0.5)
    assert run.result().final_pose["husky"]["yaw"] != before
    assert run.problems == ()
"""


def test_a_reset_begins_time_anew_and_leaves_the_body_where_it_is(ros: Ros) -> None:
    ros.body("--lockstep")
    ros.run(sys.executable, "-c", RESET)


def test_when_the_run_ends_the_robot_stands(ros: Ros) -> None:
    ros.body("--pace", "realtime")
    found = result(ros, "--world", "ros", "--until", "2s", "-s", "world.options={time: wall}")
    assert abs(found["final_pose"]["husky"]["yaw"] - 3.14) > 0.1
    twist = ros.run("rostopic", "echo", "-n", "1", "/husky/odom/twist/twist/angular/z")
    assert abs(float(twist.split()[0])) < 0.01
