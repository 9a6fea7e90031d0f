"""A run says what the check of its experiment doubts, once and everywhere the same."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import nrp_core
from nrp_core.checks import warnings

Nrp = Callable[..., Any]

DRIVES = """
from geometry_msgs.msg import Twist, Vector3


@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t):
    return Twist(linear=Vector3(x=1.0))
"""
TWICE = DRIVES + DRIVES[DRIVES.index("@") :].replace("drive", "drive_too")
SENDS_NOTHING = DRIVES.replace("return Twist", "Twist")
RAISES = DRIVES.replace("return", "turn = Vector3()\n    turn.w = 1.0\n    return").replace(
    "x=1.0", "x=turn.x"
)
OF_THE_ROBOT = {"NRP264", "NRP384"}
"""The robot of these experiments has links without inertia, and sides that Gazebo exchanges."""


def codes_of(problems: list[dict[str, Any]]) -> list[str]:
    return sorted(problem["code"] for problem in problems if problem["code"] not in OF_THE_ROBOT)


@pytest.fixture
def driven(experiment: Path) -> Callable[[str], list[str]]:
    """Return a function that gives the arguments of a run with other transfer functions."""

    def of(functions: str) -> list[str]:
        (experiment / "mine.py").write_text(functions)
        return [str(experiment), "-s", f"transfer_functions=[{experiment}/mine.py]", "-s", "criteria=null"]

    return of


@pytest.mark.parametrize(("functions", "codes"), [
    (DRIVES, []),
    (TWICE, ["NRP229"]),
    (SENDS_NOTHING, ["NRP248"]),  # without a command an event never happens
])  # fmt: skip
def test_warnings_of_a_check_are_problems_on_every_surface(
    nrp: Nrp, driven: Callable[[str], list[str]], tmp_path: Path, functions: str, codes: list[str]
) -> None:
    given = driven(functions)
    done = nrp("run", *given, "--record", tmp_path / "recording", "--json")
    data = json.loads(done.out)
    assert codes_of(data["problems"]) == codes
    assert (done.code, data["complete"]) == (0, True)
    assert json.loads(nrp("inspect", tmp_path / "recording", "--json").out)["problems"] == data["problems"]
    done = nrp("run", *given)
    assert [done.out.count(f"[{code}]") for code in codes] == [1] * len(codes)
    assert "warning" in done.err
    result = nrp_core.run(given[0], given[2::2])
    assert codes_of(result.to_dict()["problems"]) == codes


def test_a_warning_about_a_line_that_failed_is_not_repeated(
    nrp: Nrp, driven: Callable[[str], list[str]]
) -> None:
    given = driven(RAISES)
    assert "NRP240" in nrp("validate", *given).err
    data = json.loads(nrp("run", *given, "--json").out)
    (problem,) = (each for each in data["problems"] if each["code"] not in OF_THE_ROBOT)
    assert problem["code"] == "NRP276"
    assert Path(problem["path"]).read_text().splitlines()[problem["line"] - 1].strip() == "turn.w = 1.0"


def test_an_error_is_followed_by_the_warnings_that_may_explain_it(nrp: Nrp, experiment: Path) -> None:
    robot = next(path for path in experiment.glob("*.sdf") if "<plugin" in path.read_text())
    text = robot.read_text()
    robot.write_text(text.replace('filename="', 'filename="other_'))
    done = nrp("run", experiment)
    assert done.code == 3
    assert "error: " in done.err
    assert f"warning: {robot}" in done.err
    assert "is unknown and has no effect [NRP260]" in done.err


def test_a_check_that_fails_is_reported_and_the_run_takes_place(
    nrp: Nrp, experiment: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise ZeroDivisionError("in a check")

    monkeypatch.setattr(warnings, "check", fails)
    done = nrp("run", experiment)
    assert done.code == 0
    assert "the check of the experiment failed: ZeroDivisionError: in a check [NRP239]" in done.out


def test_a_long_duration_with_a_unit_is_reported_once(nrp: Nrp, experiment: Path) -> None:
    done = nrp("run", experiment, "-s", "duration=100ms", "-s", "criteria=null", "--until", "2s")
    assert done.out.count("the duration of the experiment is 0.1 s [NRP279]") == 1
    assert "duration" not in done.err


@pytest.mark.parametrize(("until_ms", "doubts_told"), [(100, 1), (300, 0)])
def test_an_event_within_the_extended_run_is_not_reported(
    nrp: Nrp, experiment: Path, until_ms: int, doubts_told: int
) -> None:
    late = "{at: 200 ms, publish: {topic: /husky/cmd_vel, value: {linear: {x: 1}}}}"
    short = ["-s", "duration=100ms", "-s", "criteria=null", "-s", f"events.late={late}"]
    told = "'late' is at 0.2 s, and the run ends at 0.1 s"
    assert (
        nrp("run", experiment, *short, "--until", f"{until_ms} ms", "--json").out.count(told) == doubts_told
    )
    result = nrp_core.run(experiment, short[1::2], until_s=until_ms / 1000)
    assert sum(told in one.message for one in result.problems) == doubts_told


def test_the_shell_ignores_codes_for_one_command(nrp: Nrp, driven: Callable[[str], list[str]]) -> None:
    given = driven(TWICE)
    for command in ("validate", "run"):
        done = nrp(command, *given)
        assert "NRP229" in done.out + done.err
        done = nrp(command, *given, "--ignore", "nrp229")
        assert "NRP229" not in done.out + done.err
    assert nrp("validate", given[0], "--ignore", "NRP2299").code == 2


def test_a_code_of_an_earlier_version_is_explained_as_removed(nrp: Nrp) -> None:
    assert "removed in 0.3" in nrp("explain", "NRP242").out
    assert "NRP240" in nrp("explain", "NRP223").out
