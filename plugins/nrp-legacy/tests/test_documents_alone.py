"""BIBI files by themselves: checked and described with the brain and the robots that they name."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_bibi.model.functions import Robot2Neuron
from nrp_bibi.model.selectors import MapSelector
from nrp_bibi.reader import read_bibi

from nrp_core.checks.validate import validate_file
from nrp_core.cli.app import run_app
from nrp_core.findings import Code, Finding, Level

BIBI = "husky_2017/bibi_configuration.bibi"


def found_in(corpus: Path, name: str) -> list[Finding]:
    return validate_file(corpus / name, [f"models=[{corpus / 'models'}]"])


def test_a_bibi_file_is_checked_in_the_experiment_that_names_it(corpus: Path) -> None:
    alone = found_in(corpus, BIBI)
    assert alone == found_in(corpus, "husky_2017/experiment_configuration.exc")
    assert {one.level for one in alone} <= {Level.WARNING, Level.NOTE}
    assert any("'lost.py'" in one.message and one.line == 14 for one in alone)


def test_without_such_an_experiment_it_is_checked_on_a_plain_floor(corpus: Path) -> None:
    (corpus / "husky_2017" / "experiment_configuration.exc").unlink()
    messages = [one.message for one in found_in(corpus, BIBI) if one.code is Code.NRP256]
    assert "the experiment does not name a room: a plain floor is used" in messages


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("right", "wrong", "code", "told"),
    [
        ("two_cells.py", "no_cells.py", Code.NRP269, "brain 'brain_model/no_cells.py' not found"),
        ("husky_model/model.sdf", "husky_model/moddel.sdf", Code.NRP256, "robot 'husky_model/moddel.sdf'"),
        ('to="1"', 'to="0"', Code.NRP211, "population 'left' has no neurons"),
        ('to="1"', 'to="9"', Code.NRP211, "population 'left' goes to neuron 8, and "),
        ("</bibi>", "</bib>", Code.NRP200, "not well-formed XML"),
    ],
)  # fmt: skip
def test_mistakes_in_a_bibi_file_are_found(
    corpus: Path, right: str, wrong: str, code: Code, told: str
) -> None:
    file = corpus / BIBI
    file.write_text(file.read_text("utf-8-sig").replace(right, wrong), "utf-8")
    assert any(one.code is code and told in one.message for one in found_in(corpus, BIBI))


def test_a_file_with_transfer_functions_alone_is_checked_by_itself(corpus: Path) -> None:
    file = corpus / "functions.bibi"
    inline = "@nrp.Robot2Neuron()\ndef f(t):\n    pass\n"
    kind = 'xmlns:x="http://www.w3.org/2001/XMLSchema-instance" x:type="PythonTransferFunction"'
    text = f"<bibi>\n<transferFunction {kind}>\n{inline}</transferFunction></bibi>"
    file.write_text(text)
    assert validate_file(file) == []
    file.write_text(text.replace("def f(t)", "def f(t, camera)"))
    (finding,) = validate_file(file)
    assert (finding.code, finding.line, finding.level) == (Code.NRP210, 3, Level.ERROR)
    (corpus / "nothing.py").write_text("x = 1\n")
    (finding,) = validate_file(corpus / "nothing.py")
    assert finding.message.startswith("declares no transfer function")


def test_a_document_is_described_where_a_run_would_leave_out_a_function(
    corpus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    models = ["--models", str(corpus / "models")]
    assert run_app(["inspect", str(corpus / BIBI), *models]) == 0
    shown = capsys.readouterr()
    assert "Neuron2Robot drive" in shown.out
    assert "does not have a transfer function 'lost.py'" in shown.err


def test_the_model_reads_forms_of_2015_and_an_empty_file(corpus: Path) -> None:
    (function,) = read_bibi(corpus / "husky_maps_2015" / "maps.bibi").transfer_function
    assert isinstance(function, Robot2Neuron)
    (group,) = function.device_group
    assert isinstance(group.neurons, MapSelector)
    assert group.neurons.pattern.population == "circuit"
    brain = read_bibi(corpus / "poses_2017" / "poses.bibi").brain_model
    assert brain is not None
    assert brain.file is None
