"""Findings: what is wrong, where, as text, data and errors."""

import ast
import json
import pickle
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

import nrp_core
from nrp_core.errors import ArgumentError, ExperimentError, TopicError, did_you_mean
from nrp_core.findings import (
    Code,
    Finding,
    Findings,
    InvalidExperimentError,
    Level,
    Weight,
    has_errors,
    headline,
    merged,
)
from nrp_core.findings.problems import is_complete
from nrp_core.findings.removed_codes import MERGED, REMOVED

WARNING = Finding(Code.NRP209, "repaired", Level.WARNING, Path("room.sdf"), 3)
ERROR = Finding(Code.NRP212, "no topic '/a'", path=Path("experiment.yaml"), line=2, column=5)


def test_a_finding_reads_like_a_compilers_message() -> None:
    assert str(ERROR) == "experiment.yaml:2:5: no topic '/a' [NRP212]"
    assert str(Finding(Code.NRP202, "wrong")) == "wrong [NRP202]"


def test_a_finding_is_plain_data() -> None:
    assert json.loads(json.dumps(ERROR.to_dict())) == {
        "code": "NRP212", "message": "no topic '/a'", "level": "error",
        "path": "experiment.yaml", "line": 2, "column": 5,
        "subject": None, "count": 1, "weight": "incomplete",
        "why": Code.NRP212.why, "suggestion": Code.NRP212.suggestion,
        "instead": None,
    }  # fmt: skip


def test_an_error_becomes_a_finding_at_the_same_place_and_back() -> None:
    error = TopicError("no topic '/a'", path="experiment.yaml", line=2, column=5)
    finding = Finding.of(error, Code.NRP212)
    assert finding == ERROR
    assert str(finding.as_error()) == str(error)


def test_a_suggested_correction_survives_errors_json_and_pickle() -> None:
    hint = did_you_mean("/odm", ["/odom", "/tf"])
    error = pickle.loads(pickle.dumps(TopicError(f"no topic '/odm'{hint}", instead=hint.instead)))
    finding = Finding.of(error, Code.NRP212)
    assert finding.instead == ("/odm", "/odom")
    assert Finding.from_dict(json.loads(json.dumps(finding.to_dict()))) == finding
    assert finding.as_error().instead == finding.instead
    assert pickle.loads(pickle.dumps(hint)).instead == hint.instead
    assert did_you_mean("/odm", ["/camera"]).instead is None


def test_several_findings_raise_as_the_first_error_among_them(golden: Golden) -> None:
    with golden.raises(ExperimentError, match="'/a'") as error:
        raise InvalidExperimentError([WARNING, ERROR])
    assert error.value.line == 2
    assert isinstance(error.value, InvalidExperimentError)
    assert error.value.findings == (WARNING, ERROR)


def test_only_errors_keep_an_experiment_from_running() -> None:
    assert not has_errors([])
    assert not has_errors([WARNING])
    assert has_errors([WARNING, ERROR])


def test_every_code_says_what_it_means_why_it_matters_and_what_to_do() -> None:
    assert len({code.summary for code in Code}) == len(Code)
    assert all(text.endswith(".") for code in Code for text in (code.summary, code.why, code.suggestion))


def test_an_error_with_findings_reaches_the_waiting_process():
    found = Finding(Code.NRP201, "an experiment has no key 'sed'", Level.ERROR, Path("a.yaml"), 3, 1)
    error = pickle.loads(pickle.dumps(InvalidExperimentError([found])))
    assert isinstance(error, InvalidExperimentError)
    assert (error.findings, error.path, error.line) == ((found,), Path("a.yaml"), 3)


def test_every_code_is_explained_in_full() -> None:
    for code in Code:
        for text in (code.summary, code.why, code.suggestion):
            assert text.endswith("."), code
        assert code.counted(3).startswith("3 "), code
        assert isinstance(code.weight, Weight)


def test_weights_are_ordered_by_their_effect_on_a_run() -> None:
    assert Weight.REMARK < Weight.ALTERED < Weight.INCOMPLETE
    assert max(finding.weight for finding in (WARNING, ERROR)) is Weight.INCOMPLETE
    assert str(Weight.ALTERED) == "altered"


def test_only_what_is_left_out_fails_or_ends_early_makes_a_run_incomplete() -> None:
    left_out = {Code.NRP256, Code.NRP269, Code.NRP272, Code.NRP382, Code.NRP385}
    failed = {Code.NRP276, Code.NRP276, Code.NRP294}
    assert {code for code in Code if code.weight is Weight.INCOMPLETE} == left_out | failed


def test_a_warning_of_a_code_that_is_an_error_elsewhere_alters_the_run() -> None:
    alias = Finding(Code.NRP212, "no topic '/a'", Level.WARNING)
    weights = {level: replace(alias, level=level).weight for level in Level}
    assert weights == {
        Level.ERROR: Weight.INCOMPLETE, Level.WARNING: Weight.ALTERED, Level.NOTE: Weight.REMARK,
    }  # fmt: skip
    assert is_complete([alias])


def test_collected_findings_are_kept_once_and_in_their_order() -> None:
    found = Findings()
    for _ in range(2):
        found.add(Code.NRP258, "the mesh 'a.dae' is replaced", subject="a.dae")
        found.add(Code.NRP260, "the plugin 'p' has no effect", subject="p")
    assert [finding.subject for finding in found] == ["a.dae", "p"]
    assert {finding.level for finding in found} == {Level.WARNING}
    assert [finding.subject for finding in found.of(Code.NRP260)] == ["p"]
    assert "the plugin 'p' has no effect" in found
    assert "the plugin" not in found


@pytest.mark.parametrize("code", ["LAB001", "NRP279", None])
def test_an_unknown_code_is_refused_when_it_is_added(code: Any, golden: Golden) -> None:
    found = Findings()
    with golden.raises(ArgumentError, match=str(code)):
        found.add(code, "the arm is cold")
    assert not found


def test_a_text_becomes_a_finding_of_the_general_code() -> None:
    found = Findings(["slow"])
    found.append("slow")
    found += ["hot", "slow"]
    assert [(finding.code, finding.message) for finding in found] == [
        (Code.NRP278, "slow"),
        (Code.NRP278, "hot"),
    ]
    assert Findings(["x"], general=Code.NRP217)[0].code is Code.NRP217


def test_findings_that_differ_only_in_place_become_one_that_counts_them() -> None:
    places = [
        Finding(Code.NRP383, "<a> is ignored", Level.WARNING, Path("a.sdf"), line) for line in (3, 4, 9)
    ]
    other = Finding(Code.NRP383, "<b> is ignored", Level.WARNING, Path("a.sdf"), 5)
    first, second = merged([*places, other])
    assert (first.line, first.count, str(first)) == (3, 3, "a.sdf:3: <a> is ignored (and 2 more) [NRP383]")
    assert second == other
    assert headline([first, second]) == "4 elements or parameters of models have no effect"
    assert headline([other]) == "<b> is ignored"


@pytest.mark.parametrize(
    "words",
    [
        "cannot save and restore", "have no '{variable", "has no {things", "; it shows: ",
        "the world backend '{", "would not move;", "cannot move models", "does not control joints",
        "cannot change its scene",
    ],
)  # fmt: skip
def test_the_words_of_a_shared_refusal_stand_in_one_file(words: str) -> None:
    root = Path(nrp_core.__file__).parents[1]
    files = [
        file
        for folder in ("nrp_core", "backends", "plugins", "bibi")
        for file in (root / folder).rglob("*.py")
        if "tests" not in file.parts and words in file.read_text("utf-8")
    ]
    assert files == [root / "nrp_core" / "findings" / "refusals.py"]


def templates(source: str) -> set[str]:
    """Return the texts and f-strings of a file with six words or more, but not its docstrings.

    A value in an f-string is ``{}``.
    """
    nodes = list(ast.walk(ast.parse(source)))
    parts: set[ast.AST] = {part for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    parts |= {node.value for node in nodes if isinstance(node, ast.Expr)}

    def text(node: ast.AST) -> str:
        if isinstance(node, ast.JoinedStr):
            return "".join(text(part) or "{}" for part in node.values)
        return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""

    return {words for node in nodes if node not in parts and len((words := text(node)).split()) > 5}


def test_the_message_of_a_finding_is_written_in_one_file() -> None:
    root = Path(nrp_core.__file__).parents[1]
    sources = [path.read_text() for path in (root / "nrp_core").rglob("*.py") if "codes" not in path.parts]
    count = Counter(words for source in sources for words in templates(source))
    of_findings = {words for source in sources if "Code.NRP" in source for words in templates(source)}
    assert len(of_findings) > 200
    assert not {words for words in of_findings if count[words] > 1}


def test_merged_codes_are_read_under_their_successors_and_not_used_again() -> None:
    removed = {*MERGED, *(code for codes in REMOVED.values() for code in codes)}
    assert not removed & Code.__members__.keys()
    assert set(MERGED.values()) <= Code.__members__.keys()
    old = Finding(Code.NRP240, "no 'amplitud'").to_dict() | {"code": "NRP223"}
    assert Finding.from_dict(old).code is Code.NRP240
