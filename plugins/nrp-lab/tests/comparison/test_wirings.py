"""Controls of the wiring are compared with the original, by nrp diff and by nrp sweep."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from nrp_lab.sweep.report import controls
from nrp_lab.sweep.table import SweepTable

from nrp_core.cli import app

BRAIN = """
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
senders = sim.Population(10, sim.IF_curr_exp(i_offset=[2.0] * 5 + [0.0] * 5), label="senders")
targets = sim.Population(10, sim.IF_curr_exp(), label="targets")
synapse = sim.StaticSynapse(weight=sim.RandomDistribution("uniform", (25.0, 35.0)), delay=1.0)
sim.Projection(senders, targets, sim.OneToOneConnector(), synapse, label="each to its own")
"""
FUNCTIONS = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64


@nrp.MapSpikeSink("rate", nrp.brain.targets[5:], nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/others", Float64))
def publish(t, rate):
    return Float64(rate.rate)
"""
EXPERIMENT = """
name: own_targets
timestep: 20 ms
duration: 60 ms
seed: 1
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
transfer_functions: [functions.py]
topics: {/others: std_msgs/Float64}
criteria:
  only_own_targets_fire:
    topic_stays: {name: /others, below: 1}
comparison: {controls: [rewire: degree_preserving, shuffle: weights]}
"""
ROOM = '<sdf version="1.6"><world name="room"/></sdf>'
REWIRED = "rewire: degree_preserving"
EXPECTED = {REWIRED: "different", "shuffle: weights": "equivalent"}
"""By construction: other pairs reach silent targets, and each of the weights makes its own target fire."""
SEEDS = 7


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    files = {"brain.py": BRAIN, "functions.py": FUNCTIONS, "experiment.yaml": EXPERIMENT, "room.sdf": ROOM}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "experiment.yaml"


def asked(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, Any]:
    """Return the exit code of a command, and its JSON."""
    code = app.run_app([*map(str, arguments), "--json"])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.heavy
def test_a_finding_depends_on_the_wiring_if_another_wiring_changes_it(
    experiment: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    monkeypatch.chdir(experiment.parent)
    page = experiment.with_name("page.html")
    code, told = asked(capsys, "diff", experiment, "--seeds", SEEDS, "--jobs", 1, "--html", page)
    assert code == 1
    assert told["answer"] == "depends on the wiring"
    assert told["controls"] == EXPECTED
    assert "shuffle: weights keeps the finding" in page.read_text()
    assert "The engines" not in page.read_text()
    assert [each["first"]["side"] for each in told["divergences"]] == ["brain", "brain"]

    code, told = asked(capsys, "diff", experiment, "--seeds", SEEDS, "--jobs", 1, "--controls", "weights")
    assert code == 0  # its runs are there already
    assert told["answer"] == "agrees across wirings"

    needs_senders = experiment.with_name("needs_senders.yaml")
    needs_senders.write_text(
        "extends: experiment.yaml\ntransfer_functions: [own.py]\ncriteria: {only_own_targets_fire: null, "
        "own_targets_fire: {topic_stays: {name: /others, above: 1}}}\n"
    )
    needs_senders.with_name("own.py").write_text(FUNCTIONS.replace("[5:]", "[:5]"))
    arguments = "--seeds", SEEDS, "--jobs", 1, "--controls", "silence: senders"
    code, told = asked(capsys, "diff", needs_senders, *arguments)
    assert (code, told["controls"]) == (1, {"silence: senders": "different"})

    sweep = experiment.with_name("sweep.yaml")
    wirings = "[[], [{rewire: degree_preserving}], [{shuffle: weights}]]"
    sweep.write_text(
        f"experiment: experiment.yaml\nmeasure: [criteria]\nvary: {{brain.controls: {wirings}}}\n"
    )
    code, told = asked(capsys, "sweep", sweep, "--workers", 1)
    assert code == 0
    assert [group["passed"] for group in told["groups"]] == [1, 0, 1]
    assert [group["values"]["brain.controls"] for group in told["groups"]] == ["original", *EXPECTED]
    assert told["controls"] == dict.fromkeys(EXPECTED, "open")  # one seed decides nothing


@pytest.mark.parametrize(
    ("keys", "passes", "told"),
    [
        (("brain.controls",), lambda wiring, seed: wiring != REWIRED, EXPECTED),
        (
            ("brain.controls",),
            lambda wiring, seed: seed % 2 or wiring != REWIRED,
            EXPECTED | {REWIRED: "open"},
        ),
        (("brain.controls", "timestep"), lambda wiring, seed: True, {}),
    ],
)
def test_a_sweep_over_wirings_alone_has_the_verdict_of_diff(
    keys: tuple[str, ...], passes: Callable[[str, int], bool], told: dict[str, str]
) -> None:
    rows = [
        {"brain.controls": wiring, "seed": seed, "brain.backend": "event", "world.backend": "mujoco",
         "criteria.it": float(passes(wiring, seed))}
        for wiring in (REWIRED, "original", "shuffle: weights") for seed in range(SEEDS)
    ]  # fmt: skip
    assert controls(SweepTable("fly", keys, ("criteria.it",), tuple(rows), "fly")) == told


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--controls", "shuffle"], "'shuffle' is shuffle: signs or shuffle: weights; give the second word"),
        (["--controls", "rewirr"], "did you mean 'rewire'?"),
        (["--controls", "silence"], "did you mean 'silence: CELLS'?"),
        (["--controls", "signs,shuffle: signs"], "'shuffle: signs' is given twice"),
        (["--controls", "all", "--engines"], "omit this option"),
        (["--worlds", "mujoco,pybullet", "--vary", "seed=1..3"], "their number is that of --seeds"),
        (["--worlds", "mujoco,pybullet", "--baseline", __file__], "test_wirings.py: is not a baseline: it"),
        (["--controls", "all", "--brains", "event,spinnaker"], "so that a difference has one cause"),
        (["-s", "brain.controls=[{shuffle: signs}]"], "is a control already (shuffle: signs)"),
    ],
)
def test_controls_that_cannot_be_compared_are_refused_before_any_run(
    experiment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], told: str
) -> None:
    results = tmp_path / "results"
    assert app.run_app(["diff", str(experiment), *arguments, "--results", str(results)]) in (2, 3)
    assert told in " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert not results.exists()
