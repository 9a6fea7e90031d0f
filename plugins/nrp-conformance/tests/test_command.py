"""``nrp conformance`` on a backend that is right."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from golden import Golden
from nrp_conformance.proof import Proof

from nrp_core.errors import ExperimentError


@pytest.fixture
def nrp_conformance(warm: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [warm / "nrp", "conformance", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)

    return run


@pytest.mark.heavy
def test_a_report_is_written_as_json_and_printed_as_text(nrp_conformance, tmp_path):
    file = tmp_path / "report.json"
    done = nrp_conformance(
        "brain", "event", "-o", "tolerance=1e-7", "--level", "contract", "--report", str(file)
    )
    assert done.returncode == 0, done.stderr
    report = json.loads(file.read_text())
    assert report["conforms"]
    assert report["options"] == {"tolerance": 1e-7}
    assert report["provider"]["distribution"] == "nrp-core"
    assert {result["level"] for result in report["results"]} == {"contract"}
    assert "  ✓ splitting a run is invisible" in done.stdout
    assert done.stdout.splitlines()[-1].startswith("brain event conforms: ")


def test_an_option_that_does_not_exist_is_refused_in_one_line(nrp_conformance):
    done = nrp_conformance("brain", "event", "-o", "tolerence=1", "--json")
    assert done.returncode == 3
    message = json.loads(done.stdout)["error"]["message"]
    assert "no option 'tolerence'" in message
    assert "'tolerance'" in message


@pytest.mark.heavy
def test_an_option_may_be_any_value_in_yaml(nrp_conformance):
    parts = "parts={a: {backend: event}, b: {backend: nobody}}"
    done = nrp_conformance("brain", "composite", "-o", parts, "--json")
    assert done.returncode == 3
    message = json.loads(done.stdout)["error"]["message"]
    assert "parts.b" in message
    assert "'nobody'" in message
    assert nrp_conformance("brain", "composite", "-o", "parts={a: ").returncode == 3


def test_an_invalid_value_of_an_option_is_reported_in_our_own_words(golden: Golden):
    with golden.raises(ExperimentError, match=r"'timestep'.*'3 ms'.*'3 s'\?$"):
        Proof("brain", "spinnaker", {"timestep": "3"}, "contract").report([])
