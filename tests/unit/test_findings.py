"""Findings: what is wrong, where, as text, data and errors."""

import json
import pickle
from pathlib import Path

import pytest

from nrp_core.errors import ExperimentError, TopicError
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level, has_errors

WARNING = Finding(Code.NRP209, "repaired", Level.WARNING, Path("room.sdf"), 3)
ERROR = Finding(Code.NRP212, "no topic '/a'", path=Path("experiment.yaml"), line=2, column=5)


def test_a_finding_reads_like_a_compilers_message() -> None:
    assert str(ERROR) == "experiment.yaml:2:5: no topic '/a' [NRP212]"
    assert str(Finding(Code.NRP215, "wrong")) == "wrong [NRP215]"


def test_a_finding_is_plain_data() -> None:
    assert json.loads(json.dumps(ERROR.to_dict())) == {
        "code": "NRP212", "message": "no topic '/a'", "level": "error",
        "path": "experiment.yaml", "line": 2, "column": 5,
        "why": Code.NRP212.why, "suggestion": Code.NRP212.suggestion,
    }  # fmt: skip


def test_an_error_becomes_a_finding_at_the_same_place_and_back() -> None:
    error = TopicError("no topic '/a'", path="experiment.yaml", line=2, column=5)
    finding = Finding.of(error, Code.NRP212)
    assert finding == ERROR
    assert str(finding.as_error()) == str(error)


def test_several_findings_raise_as_the_first_error_among_them() -> None:
    with pytest.raises(ExperimentError, match=r"experiment\.yaml:2:5: no topic '/a'") as error:
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


def test_an_error_with_findings_reaches_whoever_waits_in_another_process():
    found = Finding(Code.NRP201, "an experiment has no key 'sed'", Level.ERROR, Path("a.yaml"), 3, 1)
    error = pickle.loads(pickle.dumps(InvalidExperimentError([found])))
    assert isinstance(error, InvalidExperimentError)
    assert (error.findings, error.path, error.line) == ((found,), Path("a.yaml"), 3)
