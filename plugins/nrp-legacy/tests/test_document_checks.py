"""Values of an old experiment that mean nothing, and elements that contradict others, are reported."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_legacy.document_checks import check_documents
from nrp_legacy.documents import read_bibi, read_experiment

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Weight

_EXC = """<ExD>
  <timeout>840</timeout><rngSeed>7</rngSeed><physicsEngine>ode</physicsEngine>
  <environmentModel src="room.sdf"><robotPose robotId="husky" x="0" ux="0" uy="0" uz="0.7" theta="0.7"/>
  </environmentModel><bibiConf src="old.bibi"/></ExD>"""
_BIBI = """<bibi xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><timestep>20</timestep>
  <brainModel><file>brain.py</file>
    <populations population="all" xsi:type="Range" from="0" to="5" step="1"/></brainModel>
  <bodyModel robotId="husky">husky.sdf</bodyModel>
  <transferFunction xsi:type="PythonTransferFunction" active="true" priority="1">pass</transferFunction>
</bibi>"""


def _doubts(folder: Path, old: str = "", new: str = "") -> list[str]:
    assert old in _EXC + _BIBI
    for name, text in (("old.exc", _EXC), ("old.bibi", _BIBI)):
        (folder / name).write_text(text.replace(old, new, 1) if old else text)
    found = list(check_documents(read_experiment(folder / "old.exc"), read_bibi(folder / "old.bibi")))
    assert all(one.code is Code.NRP216 and one.line for one in found)
    return [one.message for one in found]


def test_an_experiment_without_mistakes_causes_no_warning(tmp_path: Path) -> None:
    assert _doubts(tmp_path) == []


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<rngSeed>7", "<rngSeed>seven", "the <rngSeed> must be a whole number, not 'seven': the seed is 0"),
        (">ode<", ">bullit<", "there is no physics engine 'bullit'; did you mean 'bullet'?: ignored"),
        (">840<", "><", "the <timeout> is empty: the run lasts 600 s"),
        ("<timeout>", '<timeout time="reel">', "the time of a <timeout> is 'reel'; did you mean 'real'?"),
        ("</timeout>", "</timeout><timeout>9</timeout>", "a second <timeout> is ignored: the one of line 2"),
        ('<robotPose robotId="husky"', '<robotPose robotId="huskyy"', "no robot 'huskyy', whose start pose"),
        ('uz="0.7" theta="0.7"', 'uz="0" theta="0"', "0 0 0 0, which is not an orientation: none is used"),
        ('uz="0.7" theta="0.7"', 'jaw="1.5"', "a start pose has no 'jaw'; did you mean 'yaw'?"),
        ("<timestep>20", "<timestep>", "the <timestep> is empty: the default is used"),
        ("</file>", "</file><file>b.py</file>", "a second <file> is ignored: the one of line 2 is used"),
        ('to="5"', 'to=""', "'to' of the population 'all' is empty: not used"),
        ('"Range"', '"Rnage"', "the population 'all' is of an unknown type 'Rnage'; did you mean 'Range'?"),
        ('step="1"', 'step="0"', "'step' of the population 'all' must be a whole number of 1 or more, not 0"),
        ('from="0"', 'from="0.5"', "'from' of the population 'all' must be a whole number of 0 or more"),
        (
            'step="1"/>',
            'step="1"/>\n<populations population="all" xsi:type="Range" from="0" to="2"/>',
            "a population 'all' stands again in line 4: that one is used",
        ),
        (
            'active="true"',
            'active="flase"',
            "active of a transfer function is 'flase'; did you mean 'false'?",
        ),
        ('priority="1"', 'priority="high"', "priority of a transfer function is 'high', not a whole number"),
    ],
)
def test_a_value_that_is_passed_over_is_reported(tmp_path: Path, old: str, new: str, words: str) -> None:
    (message,) = _doubts(tmp_path, old, new)
    assert words in message


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("bodyModel", "bodymodle", Code.NRP256),
        ("brainModel", "BrainModel", Code.NRP269),
        ("environmentModel", "enviromentModel", Code.NRP256),
        ("transferFunction", "trasferFunction", Code.NRP272),
    ],
)
def test_a_part_whose_element_is_misspelt_is_missing_from_the_run(
    tmp_path: Path, old: str, new: str, code: Code
) -> None:
    for name, text in (("old.exc", _EXC), ("old.bibi", _BIBI)):
        (tmp_path / name).write_text(text.replace(f"<{old}", f"<{new}").replace(f"</{old}", f"</{new}"))
    found = list(check_documents(read_experiment(tmp_path / "old.exc"), read_bibi(tmp_path / "old.bibi")))
    assert [(one.code, one.message) for one in found] == [
        (code, f"<{new}> is ignored; did you mean <{old}>?")
    ]
    assert code.weight is Weight.INCOMPLETE


@pytest.mark.parametrize("names", ["", ' robotId="cart"'])
def test_a_robot_with_the_name_of_another_is_missing_from_the_run(tmp_path: Path, names: str) -> None:
    (tmp_path / "old.exc").write_text(_EXC)
    body = f"<bodyModel{names}>husky.sdf</bodyModel>"
    (tmp_path / "old.bibi").write_text(f"<bibi>\n{body}\n{body}</bibi>")
    found = check_documents(read_experiment(tmp_path / "old.exc"), read_bibi(tmp_path / "old.bibi"))
    (robot,) = [one for one in found if one.code is Code.NRP256]
    assert (robot.line, robot.weight) == (2, Weight.INCOMPLETE)
    assert "stands again in line 3: this one is left out" in robot.message


@pytest.mark.parametrize("tag", ["transferFunctionImport", "transferFunctionInline"])
def test_elements_that_are_read_as_functions_are_not_reported(tmp_path: Path, tag: str) -> None:
    assert _doubts(tmp_path, "</bibi>", f'<{tag} src="one.py"/></bibi>') == []


def test_only_mistakes_in_experiments_of_the_platform_cause_warnings(corpus: Path) -> None:
    doubted = [
        one.message
        for path in corpus.glob("*/*.exc")
        for bibi in path.parent.glob("*.bibi")
        for one in check_documents(read_experiment(path), read_bibi(bibi))
    ]
    assert doubted == [
        "priority of a transfer function is 'high', not a whole number: it is 0"
    ]  # of students_2018


@pytest.mark.parametrize(("second", "is_reported"), [("b", False), ("a", True)])
def test_two_state_machines_with_one_id_are_reported(tmp_path: Path, second: str, is_reported: bool) -> None:
    machines = f"""<experimentControl>
      <stateMachine id="a" src="one.exd"/>
      <stateMachine id="{second}" src="two.exd"/></experimentControl>"""
    found = _doubts(tmp_path, '<bibiConf src="old.bibi"/>', f'<bibiConf src="old.bibi"/>{machines}')
    assert [one.startswith("the state machine in line 5 has the same id, 'a'") for one in found] == [
        True
    ] * is_reported


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        (">husky.sdf<", "> <", Code.NRP256, "the robot 'husky' is left out: its <bodyModel> names no file"),
        (">brain.py<", "><", Code.NRP269, "the brain is left out: its <brainModel> has populations, and"),
        ("</environmentModel>", "</environmentModel><experimentControl><stateMachine id='a' src=''/>"
         "</experimentControl>", Code.NRP272, "the state machine 'a' is left out: it names no file"),
    ],
)  # fmt: skip
def test_a_part_that_names_no_file_is_left_out_and_reported(
    tmp_path: Path, old: str, new: str, code: Code, words: str
) -> None:
    for name, text in (("old.exc", _EXC), ("old.bibi", _BIBI)):
        (tmp_path / name).write_text(text.replace(old, new, 1))
    found = list(check_documents(read_experiment(tmp_path / "old.exc"), read_bibi(tmp_path / "old.bibi")))
    assert [(one.code, words in one.message) for one in found] == [(code, True)]
    assert code.weight is Weight.INCOMPLETE


def test_a_room_without_a_file_is_a_plain_floor(tmp_path: Path) -> None:
    for name, text in (("old.exc", _EXC.replace(' src="room.sdf"', "")), ("old.bibi", _BIBI)):
        (tmp_path / name).write_text(text)
    (tmp_path / "husky.sdf").write_text(
        "<sdf version='1.6'><model name='husky'><link name='l'/></model></sdf>"
    )
    (tmp_path / "brain.py").write_text("")
    found = validate_file(tmp_path / "old.exc")
    assert any("the experiment does not name a room: a plain floor is used" in one.message for one in found)
    assert not any("is 'scene' the file of a robot?" in one.message for one in found)
