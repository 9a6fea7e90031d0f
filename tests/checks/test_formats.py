"""What other programs read, and what people are told of a code."""

from __future__ import annotations

import json
import re
import runpy
from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.cli import app
from nrp_core.cli.finding_formats import github, sarif
from nrp_core.findings import Code, Finding, Level

FINDINGS = [
    Finding(Code.NRP240, "'a' has no 'b': 100%\nno", path=Path("own folder/a,b.py"), line=3, column=5),
    Finding(Code.NRP205, "no backend", Level.WARNING),
    Finding(Code.NRP240, "again", Level.NOTE, Path("x.py"), 1),
]


def test_sarif_has_a_rule_for_each_code_and_a_place_for_each_result() -> None:
    log = json.loads(json.dumps(sarif(FINDINGS)))
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == ["NRP205", "NRP240"]
    assert all(rule["help"]["text"] for rule in rules)
    assert [rules[result["ruleIndex"]]["id"] for result in run["results"]] == ["NRP240", "NRP205", "NRP240"]
    assert [result["level"] for result in run["results"]] == ["error", "warning", "note"]
    place = run["results"][0]["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "own%20folder/a%2Cb.py"
    assert place["region"] == {"startLine": 3, "startColumn": 5}
    assert "locations" not in run["results"][1]
    assert run["results"][2]["locations"][0]["physicalLocation"]["region"] == {"startLine": 1}


def test_github_shows_each_finding_at_its_line() -> None:
    assert list(github(FINDINGS)) == [
        "::error file=own folder/a%2Cb.py,line=3,col=5,title=NRP240::'a' has no 'b': 100%25%0Ano",
        "::warning title=NRP205::no backend",
        "::notice file=x.py,line=1,title=NRP240::again",
    ]


# -- the command line


@pytest.fixture
def nrp(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs a command in this process."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        return app.run_app(arguments), *capsys.readouterr()

    return run


def test_a_code_is_explained(nrp: Callable[..., tuple[int, str, str]]) -> None:
    code, out, _ = nrp("explain", "nrp240")
    assert code == 0
    for text in ("NRP240", Code.NRP240.summary, Code.NRP240.why, Code.NRP240.suggestion):
        assert text in out


def test_a_code_is_explained_to_programs(nrp: Callable[..., tuple[int, str, str]]) -> None:
    assert json.loads(nrp("explain", "NRP201", "--json")[1])["why"] == Code.NRP201.why
    assert len(json.loads(nrp("explain", "--json")[1])["codes"]) == len(Code)


def test_all_codes_are_listed(nrp: Callable[..., tuple[int, str, str]]) -> None:
    assert nrp("explain")[1].count("\n") == len(Code)


def test_an_unknown_code_gets_a_hint(nrp: Callable[..., tuple[int, str, str]]) -> None:
    code, _, err = nrp("explain", "NRP2O3")
    assert code == 2
    assert "did you mean" in err


@pytest.mark.one_of(3)
@pytest.mark.parametrize("form", ["text", "json", "sarif", "github"])
def test_errors_end_with_3_in_every_format(
    nrp: Callable[..., tuple[int, str, str]], husky: Path, form: str
) -> None:
    assert nrp("validate", str(husky), "--format", form)[0] == 0
    (husky / "listing2.py").write_text((husky / "listing2.py").read_text().replace("leftred", "leftgreen"))
    code, out, err = nrp("validate", str(husky), "--format", form)
    assert code == 3
    assert "NRP240" in out + err
    assert ("listing2.py" in out) is (form != "text")


@pytest.mark.parametrize("form", ["text", "json", "sarif", "github"])
def test_a_missing_experiment_is_a_finding_in_every_format(
    nrp: Callable[..., tuple[int, str, str]], form: str
) -> None:
    code, out, err = nrp("validate", "nowhere", "--format", form)
    assert code == 3
    assert "there is no experiment or file 'nowhere'" in out + err
    assert "NRP204" in out + err
    if form in ("json", "sarif"):
        json.loads(out)


def test_a_run_refuses_an_experiment_in_the_words_of_a_check(
    nrp: Callable[..., tuple[int, str, str]], husky: Path
) -> None:
    text = (husky / "listing2.py").read_text()
    assert "poisson)" in text
    (husky / "listing2.py").write_text(text.replace("poisson)", "poisson, rate=-1.0)", 1))
    checked = json.loads(nrp("validate", str(husky), "--json")[1])
    code, out, _ = nrp("run", str(husky), "--json")
    errors = [one for one in checked["findings"] if one["level"] == "error"]
    assert code == 3
    assert errors
    assert json.loads(out)["error"]["findings"][: len(errors)] == errors


def test_a_run_reports_each_mistake_once_and_warnings_as_warnings(
    nrp: Callable[..., tuple[int, str, str]], husky: Path
) -> None:
    listing = husky / "listing1.py"
    listing.write_text(listing.read_text().replace("/husky/cmd_vel", "/husky/cmdvel"))
    robot = husky / "husky.sdf"
    robot.write_text(re.sub("<inertial>.*?</inertial>", "", robot.read_text(), count=1, flags=re.DOTALL))
    assert "<inertial>" in nrp("validate", str(husky))[2]
    code, _, err = nrp("run", str(husky))
    assert code == 3
    assert [line.count("cmdvel") for line in err.splitlines()] == [1, 0]
    assert err.splitlines()[1].startswith("warning: ")
    assert "<inertial>" in err.splitlines()[1]


def test_the_text_for_people_gives_the_reason_and_the_fix(
    nrp: Callable[..., tuple[int, str, str]], husky: Path
) -> None:
    (husky / "listing2.py").write_text((husky / "listing2.py").read_text().replace("leftred", "leftgreen"))
    _, out, err = nrp("validate", str(husky))
    assert out == "not valid\n"
    assert f"why: {Code.NRP240.why}" in err
    assert f"fix: {Code.NRP240.suggestion}" in err


def test_the_reference_page_equals_the_table() -> None:
    path = Path(__file__).parents[2] / "docs" / "generate_findings.py"
    names = runpy.run_path(str(path))
    text = names["TARGET"].read_text("utf-8")
    assert text == names["page"](), "run docs/generate_findings.py"
