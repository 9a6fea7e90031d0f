"""The brain script is executed in a process of its own, and its network is kept."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_conformance.brain import kit
from nrp_conformance.brain.kit import SAMPLES

from nrp_core.checks import confined_network, network_summary
from nrp_core.checks.confined_network import ConfinedBuild
from nrp_core.checks.network_summary import described, skeleton_of, with_stand_ins
from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level
from nrp_core.network.files.script import load_network
from nrp_core.network.pynn import builder
from nrp_core.network.rewiring import Neuromodulation, Rewiring


def codes(folder: Path) -> list[str]:
    """Return the codes of what is said of an experiment."""
    return [finding.code.name for finding in validate_file(folder)]


def problem(folder: Path) -> Finding:
    """Return the only finding about an experiment that is not a note about its functions."""
    (finding,) = [one for one in validate_file(folder) if one.level is not Level.NOTE]
    return finding


def test_a_skeleton_has_the_neurons_of_its_network(husky: Path) -> None:
    network = load_network(husky / "brain.py", populations={"some": [0, 2], "all": None})
    skeleton = skeleton_of(json.loads(json.dumps(described(network))))
    assert list(skeleton.populations) == list(network.populations)
    assert {name: list(ids) for name, ids in skeleton.views.items()} == {
        name: list(ids) for name, ids in network.views.items()
    }
    assert {one.synapse_type for one in skeleton.projections} == {
        one.synapse_type for one in network.projections
    }
    assert (skeleton.size, skeleton.timestep_ms) == (network.size, network.timestep_ms)


@pytest.mark.parametrize("is_large", [False, True])
def test_a_skeleton_has_a_projection_of_each_kind_that_a_backend_may_refuse(
    is_large: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A small network's skeleton has all projections, and that of a large network one of each kind."""
    monkeypatch.setattr(network_summary, "_ALL", 3 if is_large else 4)
    parts = [kit.cells(SAMPLES["IF_curr_exp"], label) for label in ("a", "b")]
    plain = kit.connect("a", "b", 0.1)
    reward = replace(plain, label="good", receptor="reward", neuromodulation=Neuromodulation(tau_d=5.0))
    grows = replace(plain, label="grows", rewiring=Rewiring(s_max=3))
    network = kit.network(*parts, plain, reward, grows, replace(plain, label="again"))
    found = skeleton_of(json.loads(json.dumps(described(network)))).projections
    again = [] if is_large else [None]
    assert [one.label for one in found] == [plain.label, "good", "grows", *(["again"] if again else [])]
    assert [one.neuromodulation for one in found] == [None, reward.neuromodulation, None, *again]
    assert [one.rewiring for one in found] == [None, None, grows.rewiring, *again]


@pytest.mark.parametrize(
    "synapse",
    ["StaticSynapse", "TsodyksMarkramSynapse", "ElectricalSynapse", "GradedSynapse", "RectifiedSynapse"],
)
def test_stand_ins_are_a_network_whatever_synapses_transmit(synapse: str) -> None:
    sim = builder()
    cells = sim.Population(3, sim.IF_cond_exp(), label="cells")
    law = getattr(sim, synapse)(weight=0.001)
    sim.Projection(cells, cells, sim.AllToAllConnector(allow_self_connections=False), law, label="joined")
    skeleton = skeleton_of(json.loads(json.dumps(described(sim.network()))))
    (joined,) = with_stand_ins(skeleton, {"joined": 6}).projections
    assert (joined.size, joined.synapse_type) == (6, law.kind)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a child process was asked about, kept answers aside."""
    from nrp_core._support import probe

    asked: list[str] = []
    run = probe._run

    def counted(command: list[str], *options: Any) -> probe.ChildResult:
        asked.extend(one for one in command if one == confined_network.CHILD)
        return run(command, *options)

    monkeypatch.setattr(probe, "_run", counted)
    return asked


def test_a_network_is_built_once_until_its_script_or_what_it_imports_changes(
    husky: Path, asked: list[str]
) -> None:
    (husky / "sizes.py").write_text("N = 8\n")
    brain = (husky / "brain.py").read_text()
    (husky / "brain.py").write_text(
        brain.replace("    8,\n", "    sizes.N,\n").replace("import nrp", "import sizes\nimport nrp")
    )
    for _ in range(3):
        assert codes(husky) == ["NRP238"]
    assert len(asked) == 1
    (husky / "sizes.py").write_text("N = 7\n")
    assert "NRP208" in codes(husky)
    assert len(asked) == 2


@pytest.mark.heavy
def test_results_are_reused_by_the_next_process(husky: Path) -> None:
    """The functions are tried again, in a child of another name."""
    program = (
        "import sys\nfrom nrp_core._support import probe\n"
        "from nrp_core.checks.confined_network import CHILD\n"
        "from nrp_core.checks.validate import validate_file\n"
        "run, asked = probe._run, []\n"
        "probe._run = lambda command, *rest: asked.append(CHILD in command) or run(command, *rest)\n"
        "validate_file(sys.argv[1], ['brain.backend=spinnaker'])\n"
        "assert asked == ([True, False] if sys.argv[2] == 'first' else [False]), asked\n"
    )
    for seed, turn in enumerate(("first", "again")):
        environment = {**os.environ, "PYTHONHASHSEED": str(seed)}
        subprocess.run([sys.executable, "-c", program, str(husky), turn], env=environment, check=True)


def test_output_of_a_script_does_not_matter(husky: Path) -> None:
    brain = husky / "brain.py"
    brain.write_text(f"import os\nprint('[1')\nos.write(1, b'[2')\n{brain.read_text()}")
    assert codes(husky) == ["NRP238"]


def test_a_script_that_does_not_end_is_a_warning(
    husky: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setattr(confined_network, "TIME_LIMIT_S", 1.0)
    (husky / "brain.py").write_text("while True:\n    pass\n")
    finding = problem(husky)
    assert (finding.code.name, finding.level) == ("NRP239", Level.WARNING)
    golden(finding.message)


def test_a_script_that_ends_its_process_does_not_end_ours(husky: Path, golden: Golden) -> None:
    (husky / "brain.py").write_text("import os\nos._exit(3)\n")
    finding = problem(husky)
    assert (finding.code.name, finding.level, finding.line) == ("NRP208", Level.ERROR, 2)
    assert "os._exit(3)" in finding.message
    golden(finding.message)
    (husky / "brain.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n")
    finding = problem(husky)
    assert (finding.code.name, finding.level) == ("NRP208", Level.ERROR)
    golden(finding.message)
    assert "SIGKILL" in finding.message


def test_a_script_is_executed_again_when_a_variable_that_it_reads_changes(
    husky: Path, asked: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    brain = husky / "brain.py"
    read = "import os\nN = int(os.environ.get('CELLS', 8))\n"
    brain.write_text(read + brain.read_text().replace("    8,\n", "    N,\n"))
    for value, found, n in ((None, "NRP238", 1), ("7", "NRP208", 2), ("8", "NRP238", 3), ("8", "NRP238", 3)):
        if value is not None:
            monkeypatch.setenv("CELLS", value)
        monkeypatch.setenv("UNREAD", str(value))
        assert found in codes(husky)
        assert len(asked) == n


def test_a_network_that_cannot_be_pickled_is_built_in_this_process(husky: Path) -> None:
    builder = ConfinedBuild(None)
    assert builder(lambda: load_network(husky / "brain.py")).size == 8
