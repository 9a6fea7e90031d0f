"""Failures of ROS are a single error that states the remedy."""

from __future__ import annotations

import subprocess

import pytest

from conftest import Ros, needs_ros

pytestmark = needs_ros

LOOP = ("run", "braitenberg_husky", "--world", "ros")


def lockstep(patience: str) -> tuple[str, str]:
    return "-s", f"world.options={{time: lockstep, patience: {patience}}}"


def errors(process: subprocess.Popen[str], timeout_s: float = 60) -> list[str]:
    said, _ = process.communicate(timeout=timeout_s)
    assert "Traceback" not in said
    assert "WARN" not in said
    return [line for line in said.splitlines() if line.startswith("error:")]


def test_without_a_master_the_error_says_how_to_start_one(no_master: Ros) -> None:
    process = no_master.nrp(*LOOP)
    (error,) = errors(process)
    assert f"no ROS master is at http://127.0.0.1:{no_master.port}" in error
    assert "roscore" in error
    assert process.returncode == 4


def test_without_a_body_the_error_names_the_topics_without_a_provider(ros: Ros) -> None:
    process = ros.nrp(*LOOP, *lockstep("2 s"))
    (error,) = errors(process)
    assert "/husky/camera" in error
    assert "/nrp/go" in error
    assert process.returncode == 1


@pytest.mark.slow
def test_two_bodies_for_one_loop_are_refused(ros: Ros) -> None:
    ros.body("--lockstep")
    ros.body("--lockstep")
    (error,) = errors(ros.nrp(*LOOP, *lockstep("20 s")))
    assert "2 bodies wait" in error


@pytest.mark.slow
def test_a_master_that_goes_away_ends_both_sides_with_one_error_each(ros: Ros) -> None:
    body = ros.body("--lockstep")
    loop = ros.nrp(*LOOP, "-s", "world.options={time: lockstep}", "-s", "pace=realtime")
    ros.until(lambda: "nrp_loop" in ros.run("rostopic", "info", "/nrp/go"))
    assert ros.master is not None
    ros.master.kill()
    for process in (loop, body):
        (error,) = errors(process)
        assert f"the ROS master at http://127.0.0.1:{ros.port} was lost" in error
        assert process.returncode == 1


@pytest.mark.slow
def test_a_body_that_goes_away_ends_the_loop_with_one_error(ros: Ros) -> None:
    body = ros.body("--lockstep", "--until", "1s")
    (error,) = errors(ros.nrp(*LOOP, *lockstep("20 s")))
    assert "the body has not answered on /nrp/done" in error
    assert body.wait(timeout=60) == 0
