"""Problems of a run: their order and groups, and commands that nothing subscribes to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import nrp_core
from nrp_core.cli.summary import print_findings
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.result import Judgement, passed_of, recorded_judgement
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, Level
from nrp_core.findings.problems import MAX_LINES, grouped, is_complete, lines_of, ordered

MESH = Finding(Code.NRP258, "the mesh is replaced", Level.WARNING, Path("b.sdf"), 3, subject="a.dae")
GHOST = Finding(Code.NRP256, "the robot 'ghost' is left out", Level.WARNING)
LATER = Finding(Code.NRP258, "another mesh is replaced", Level.WARNING, Path("b.sdf"), 7, subject="b.dae")
NOTED = Finding(Code.NRP284, "no snapshots are recorded", Level.WARNING)


def test_problems_come_by_weight_then_by_place_and_once() -> None:
    elsewhere = replace(MESH, line=9)
    assert ordered([NOTED, LATER, MESH, GHOST, elsewhere]) == (GHOST, replace(MESH, count=2), LATER, NOTED)


def test_problems_of_one_code_are_one_line_unless_details_are_asked_for() -> None:
    judgement = Judgement("finished", ordered([MESH, LATER, GHOST]), {}, 1.0, 1.0)
    assert [line for _, line in judgement.lines()] == [
        "✗ the robot 'ghost' is left out [NRP256]",
        "! 2 meshes, textures or materials are replaced [NRP258]",
    ]
    assert [line.strip() for _, line in judgement.lines(details=True)][2:] == [
        "b.sdf:3: the mesh is replaced",
        "b.sdf:7: another mesh is replaced",
    ]
    (line,) = [line for _, line in Judgement("finished", (MESH,), {}, 1.0).lines(details=True)]
    assert line == "! b.sdf:3: the mesh is replaced [NRP258]"
    many, each = [
        line for _, line in Judgement("finished", (replace(MESH, count=3),), {}, 1.0).lines(details=True)
    ]
    assert many == "! 3 meshes, textures or materials are replaced [NRP258]"
    assert each.strip() == "b.sdf:3: the mesh is replaced (and 2 more)"
    assert [len(group.findings) for group in grouped(judgement.problems)] == [1, 2]


def test_a_summary_has_five_lines_besides_those_of_missing_things() -> None:
    codes = [Code.NRP210, Code.NRP212, Code.NRP216, Code.NRP204, Code.NRP217, Code.NRP237, Code.NRP297]
    found = ordered([GHOST, *(Finding(code, code.name, Level.WARNING) for code in codes)])
    missing, *others = [line for _, line in lines_of(found)]
    assert "NRP256" in missing
    assert len(others) == MAX_LINES == 5
    assert others[:4] == [f"! {code.name} [{code.name}]" for code in codes[:4]]
    assert others[4] == "! 3 others of 3 kinds [NRP217 NRP237 NRP297]"
    every = "\n".join(line for _, line in lines_of(found, details=True))
    assert all(f"[{code.name}]" in every for code in codes)


def test_findings_about_models_share_a_line_if_there_are_too_many() -> None:
    codes = [Code.NRP210, Code.NRP258, Code.NRP264, Code.NRP291, Code.NRP297, Code.NRP237]
    found = ordered(Finding(code, code.name, Level.WARNING) for code in codes)
    found = tuple(replace(each, count=4) if each.code is Code.NRP264 else each for each in found)
    lines = [line.rpartition(" [")[2] for _, line in lines_of(found)]
    assert lines == ["NRP210]", "NRP291]", "NRP258 NRP264]", "NRP297]", "NRP237]"]
    assert any(" 5 parts, values or meshes of models " in line for _, line in lines_of(found))
    assert len(list(lines_of(found[:5]))) == 5  # of a code each


def test_only_the_weightiest_problems_make_a_run_incomplete() -> None:
    assert is_complete([MESH, NOTED])
    assert not is_complete([MESH, GHOST])


@pytest.mark.parametrize(
    ("state", "complete", "criteria", "passed"),
    [
        ("finished", True, [], None),
        ("finished", True, [True, True], True),
        ("finished", True, [True, None], None),
        ("finished", True, [None, False], False),
        ("finished", False, [True], None),
        ("finished", False, [False], False),
        ("failed", False, [True], False),
        ("failed", False, [], False),
        ("interrupted", False, [True], None),
    ],
)
def test_a_run_passes_only_if_it_is_complete_and_meets_its_criteria(
    state: str, complete: bool, criteria: list[bool | None], passed: bool | None
) -> None:
    assert passed_of(state, complete, criteria) is passed


def test_a_result_of_version_0_1_is_judged_by_its_failures() -> None:
    failure = {"function": "wrong", "path": "wrong.py", "line": 4, "t_s": 1.02, "error": "ValueError: deep"}
    result = {"passed": True, "criteria": {"c": {"passed": True}}, "failures": [failure], "warnings": ["odd"]}
    judgement = recorded_judgement({"state": "finished", "result": result}, 3.0)
    assert judgement is not None
    assert (judgement.complete, judgement.passed) == (False, None)
    assert [problem.code for problem in judgement.problems] == [Code.NRP272, Code.NRP278]


def test_a_file_without_metadata_has_no_judgement() -> None:
    assert recorded_judgement({}, 3.0) is None


# -- events


WAITING = """\
extends: experiment.yaml
name: waiting
criteria: null
events:
  arrived: null
  soon: {at: 100 ms}
  far: {when: {near: {model: husky, visual: wall/body/glass, within: 0.9 m}}}
  later: {when: {event: far}}
  last: {when: {event: later, after: 20 ms}}
"""


@pytest.mark.parametrize(
    ("duration", "until_s", "messages"),
    [
        ("600 ms", None, ["the event 'far' never happened, and so not 'later', 'last'"]),
        ("600 ms", 0.2, []),  # they may still happen
        ("3 s", None, []),
    ],
)
def test_an_event_that_never_happened_is_a_remark_at_the_end(
    fakes: None, drive_to_the_wall: Path, duration: str, until_s: float | None, messages: list[str]
) -> None:
    file = drive_to_the_wall / "waiting.yaml"
    file.write_text(WAITING)
    with Run(load_experiment(file, [f"duration={duration}"])) as simulation:
        simulation.run(until_s)
        result = simulation.result()
    found = [one for one in result.problems if one.code is Code.NRP248]
    assert [(one.message, one.line) for one in found] == [(message, 7) for message in messages]
    assert result.complete


@pytest.mark.parametrize(
    ("late", "messages"),
    [
        ("{at: 4 s}", []),
        (
            "{at: 4 s}\n  behind: {when: {event: late}}",
            ["the event 'late' never happened, and so not 'behind'"],
        ),
        ("{when: {event: other}}\n  other: {when: {topic: {name: /speed, field: data, above: 9}}}",
         ["the event 'other' never happened, and so not 'late'"]),
    ],
)  # fmt: skip
def test_an_event_with_a_warning_is_not_reported_again_at_the_end(
    fakes: None, drive_to_the_wall: Path, late: str, messages: list[str]
) -> None:
    file = drive_to_the_wall / "late.yaml"
    file.write_text(f"extends: {drive_to_the_wall}\ncriteria: null\nevents:\n  late: {late}\n")
    result = nrp_core.run(file)
    found = [one.message for one in result.problems if one.code is Code.NRP248]
    assert [one for one in found if "never happened" in one] == messages
    assert sum("'late' is at 4 s" in one.message for one in result.problems) == ("4 s" in late)
    override = "events.soon={at: 5 s}"
    told = [one.message for one in nrp_core.run(file, [override]).problems if "'soon'" in one.message]
    assert told == [f"in the override '{override}': 'soon' is at 5 s, and the run ends at 3 s"]


# -- variables


@pytest.mark.parametrize(
    ("value", "initial", "is_lost"),
    [
        ("last.value + numpy.mean([])", "0.0", True),
        ("numpy.array([1.0, math.nan])", "None", True),
        ("[0.0, (math.nan,)]", "None", True),
        ("last.value", "math.nan", False),
        ("math.inf", "0.0", False),
    ],
)
@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value")
def test_a_variable_that_has_become_nan_is_a_problem(
    fakes: None, drive_to_the_wall: Path, value: str, initial: str, is_lost: bool
) -> None:
    file = drive_to_the_wall / "more.py"
    file.write_text(
        f"import math\nimport numpy\n\n@nrp.MapVariable('last', initial_value={initial})\n"
        f"@nrp.Robot2Neuron()\ndef mean(t, last):\n    last.value = {value}\n"
    )
    functions = f"transfer_functions=[{drive_to_the_wall / 'drive.py'}, {file}]"
    with Run(load_experiment(drive_to_the_wall, [functions])) as simulation:
        simulation.run(0.1)
        found = [one for one in simulation.problems if one.code is Code.NRP277]
    assert [(one.path, one.line, one.subject) for one in found] == [(file, 4, "mean")] * is_lost


# -- rates


@pytest.mark.parametrize(
    ("rate", "until_s", "words"),
    [
        ("0.1 + 0.2 * t", None, "changed and was never more than 0.7 Hz; is it meant in kHz?"),
        ("0.1 + 0.2 * t", 0.2, ""),  # it may still rise
        ("0.5", None, ""),  # a background
        ("0.5 if t > 2.8 else 0.0", None, ""),  # it waits for something
        ("[100.0 * t, 0.0]", None, ""),
        ("[0.1 * t, 0.0]", None, "changed and was never more than 0.3 Hz; is it meant in kHz?"),
        ("3e4 * t", 0.6, "reached 1.8e+04 Hz; is it meant in mHz?"),
    ],
)
def test_rates_in_another_unit_are_a_remark(
    fakes: None, drive_to_the_wall: Path, rate: str, until_s: float | None, words: str
) -> None:
    file = drive_to_the_wall / "more.py"
    file.write_text(
        "@nrp.MapSpikeSource('eye', nrp.brain.sensors, nrp.poisson)\n@nrp.Robot2Neuron()\n"
        f"def see(t, eye):\n    eye.rate = {rate}\n"
    )
    functions = f"transfer_functions=[{drive_to_the_wall / 'drive.py'}, {file}]"
    with Run(load_experiment(drive_to_the_wall, [functions])) as simulation:
        simulation.run(until_s)
        result = simulation.result()
    told = [one.message for one in result.problems if one.code is Code.NRP297]
    told = [one for one in told if one.startswith("the rate of 'eye'")]
    assert told == ([f"the rate of 'eye' in 'see' {words}"] if words else [])
    assert result.complete


# -- commands


@pytest.fixture
def unheard(fakes: None, drive_to_the_wall: Path) -> Callable[..., list[Any]]:
    """Return a function that runs functions beside those of the experiment; it returns unheard topics."""

    def run(source: str, *overrides: str) -> list[Any]:
        (drive_to_the_wall / "more.py").write_text(source)
        functions = f"transfer_functions=[{drive_to_the_wall / 'drive.py'}, {drive_to_the_wall / 'more.py'}]"
        with Run(load_experiment(drive_to_the_wall, [functions, *overrides])) as simulation:
            simulation.run(0.1)
            problems = simulation.problems
        return [(one.subject, one.line, one.message) for one in problems if one.code is Code.NRP212]

    return run


SENDS = """
@nrp.Neuron2Robot(Topic('{topic}', geometry_msgs.msg.Twist))
def sends(t):
    return geometry_msgs.msg.Twist()
"""
NOTHING = """
@nrp.Neuron2Robot()
def nothing(t): ...
"""
LISTENS = """
@nrp.MapRobotSubscriber('heard', Topic('/husky/cmd_vell', geometry_msgs.msg.Twist))
@nrp.Robot2Neuron()
def listens(t, heard): ...
"""


def test_a_misspelt_command_is_reported_with_the_topic_that_was_meant(unheard: Any) -> None:
    ((topic, line, message),) = unheard(SENDS.format(topic="/husky/cmd_vell"), "strict=false")
    assert (topic, line) == ("/husky/cmd_vell", 2)
    assert message.endswith("so its commands have no effect; did you mean '/husky/cmd_vel'?")


def test_a_declared_topic_is_reported_only_if_it_resembles_one_of_the_world(unheard: Any) -> None:
    declared = "topics={{/speed: std_msgs/Float64, {0}: geometry_msgs/Twist}}"
    for topic, times in (("/husky/cmd_vell", 1), ("/seen/by/people", 0)):
        assert len(unheard(SENDS.format(topic=topic), declared.format(topic))) == times


def test_a_command_with_a_subscriber_is_not_reported(unheard: Any) -> None:
    assert unheard(SENDS.format(topic="/husky/cmd_vell") + LISTENS, "strict=false") == []


def test_an_event_whose_message_nothing_subscribes_to_is_reported(unheard: Any) -> None:
    event = "events.shout={at: 0 s, publish: {topic: /speeed, value: 1}}"
    topics = "topics={/speed: std_msgs/Float64, /speeed: std_msgs/Float64}"
    assert unheard(NOTHING, event, topics) == []  # declared, and the world has nothing like it
    wrong = "topics={/speed: std_msgs/Float64, /husky/cmd_vell: geometry_msgs/Twist}"
    ((topic, line, _),) = unheard(
        NOTHING, event.replace("/speeed, value: 1", "/husky/cmd_vell, value: {}"), wrong
    )
    assert (topic, line) == ("/husky/cmd_vell", None)


@pytest.mark.parametrize(("found", "has_more"), [([MESH], False), ([MESH, LATER], True)])
def test_details_are_offered_only_if_there_are_more(
    found: list[Finding], has_more: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    print_findings(found, details=False)
    assert ("-v" in capsys.readouterr().err) is has_more
