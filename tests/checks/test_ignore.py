"""Codes that are switched off, in the experiment or in the shell."""

from __future__ import annotations

from pathlib import Path

import pytest

import nrp_core
from nrp_core.checks.validate import validate_file
from nrp_core.errors import ExperimentError

TWICE = """
from geometry_msgs.msg import Twist


@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t):
    return Twist()


@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive_too(t):
    return Twist()
"""


@pytest.fixture
def twice(husky: Path) -> list[str]:
    """The settings of an experiment in which two functions publish on one topic."""
    (husky / "twice.py").write_text(TWICE)
    return [f"transfer_functions=[{husky}/twice.py]", "duration=100 ms", "criteria=null"]


def test_a_code_that_the_experiment_ignores_is_reported_nowhere(husky: Path, twice: list[str]) -> None:
    def codes(*settings: str) -> tuple[bool, bool]:
        given = [*twice, *settings]
        found = {one.code.name for one in validate_file(husky, given)}
        problems = {one.code.name for one in nrp_core.run(husky, given).problems}
        return "NRP229" in found, "NRP229" in problems

    assert codes() == (True, True)
    assert codes("checks.ignore=[NRP229]") == (False, False)
    assert codes("checks.ignore=[NRP242]") == (True, True)  # of an earlier version


def test_an_unknown_code_is_refused(husky: Path) -> None:
    with pytest.raises(ExperimentError, match="NRP229"):
        nrp_core.load_experiment(husky, ["checks.ignore=[NRP2299]"])


def test_errors_are_reported_although_their_code_is_ignored(husky: Path) -> None:
    (husky / "twice.py").write_text(TWICE.replace("/husky/cmd_vel", "/husky/cmd_ve"))
    settings = [f"transfer_functions=[{husky}/twice.py]"]
    (known,) = {one.code.name for one in validate_file(husky, settings) if one.level == "error"}
    ignored = validate_file(husky, [*settings, f"checks.ignore=[{known}]"])
    assert known in {one.code.name for one in ignored}
