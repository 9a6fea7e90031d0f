"""A transfer function freezes and sets weights: checked, recorded, replayed, restored and reset alike."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from typer import BadParameter

from nrp_core._support.used_files import FilesRead
from nrp_core.checks.validate import validate_file
from nrp_core.cli.session import RunRequest, Session
from nrp_core.errors import TransferFunctionRaisedError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest

S = 10**9
BRAIN = """\
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
eyes = sim.Population(10, sim.SpikeSourcePoisson(rate=40.0), label="eyes")
wheels = sim.Population(2, sim.IF_curr_exp(), label="wheels")
rule = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.01, A_minus=0.012),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=4.0),
    weight=2.0,
    delay=1.0,
)
sim.Projection(eyes, wheels, sim.AllToAllConnector(), rule, label="learned")
sim.Projection(eyes, wheels, sim.AllToAllConnector(), sim.StaticSynapse(weight=1.0, delay=2.0), label="set")
"""
FUNCTIONS = """\
@nrp.MapWeights("learned", nrp.brain.projection("learned"))
@nrp.MapWeights("fixed", nrp.brain.projection("set"))
@nrp.MapCSVRecorder("rows", "weights.csv", ["t", "learned", "fixed"])
@nrp.Robot2Neuron()
def teach(t, learned, fixed, rows):
    learned.plastic = t < 0.5
    fixed.values[fixed.pre_index == 3] *= 0.9
    rows.record_entry(t, learned.values.mean(), fixed.values.mean())
"""
EXPERIMENT = """\
name: weights
duration: 1 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: floor.sdf}
transfer_functions: [functions.py]
"""
FLOOR = """\
<sdf version="1.6"><world name="floor"><model name="ground"><static>true</static><link name="link">
  <collision name="all"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
</link></model></world></sdf>
"""
MODES = pytest.mark.parametrize(
    "options", ["{}", "{resolution: 0.1 ms}", "{resolution: 0.1 ms, lazy: never}"]
)


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    texts = {"brain.py": BRAIN, "functions.py": FUNCTIONS, "floor.sdf": FLOOR, "experiment.yaml": EXPERIMENT}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "experiment.yaml"


def rows(run: Run, folder: Path) -> np.ndarray:
    (path,) = run.write_csv(folder)
    with path.open() as file:
        return np.array([list(map(float, row)) for row in list(csv.reader(file))[1:]])


@pytest.mark.heavy
@MODES
def test_weights_are_frozen_and_set_step_by_step(experiment: Path, tmp_path: Path, options: str) -> None:
    with Run(load_experiment(experiment, [f"brain.options={options}"])) as run:
        run.run()
        found = rows(run, tmp_path)
        t, learned, fixed = found.T
        assert len(t) == 50
        assert len(np.unique(learned[t < 0.5])) > 20
        assert len(np.unique(learned[t >= 0.5])) == 1
        # 2 of 20 weights of 1 nA; a grid stores single precision
        assert fixed == pytest.approx(0.9 + 0.1 * 0.9 ** np.arange(1, 51), rel=1e-6)


@MODES
def test_a_snapshot_and_a_reset_restore_them(experiment: Path, tmp_path: Path, options: str) -> None:
    with Run(load_experiment(experiment, [f"brain.options={options}", "seed=3"])) as run:
        run.run_until(0.6)
        saved = run.snapshot()
        run.run()
        first = rows(run, tmp_path)
        run.restore(saved)
        run.run()
        assert rows(run, tmp_path).tolist() == first.tolist()
        run.reset()
        assert run.brain.is_plastic("learned")
        assert (run.brain.read_weights("set") == 1.0).all()


@pytest.mark.one_of(6)
@MODES
def test_a_replay_is_the_same(experiment: Path, tmp_path: Path, options: str) -> None:
    folder = tmp_path / "recording"
    with FilesRead() as files, Run(load_experiment(experiment, [f"brain.options={options}"])) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=S // 4)
        run.run()
        recording_folder.close("finished")
    for request in (ReplayRequest(), ReplayRequest(from_ns=round(0.62 * S))):
        with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
            assert again.verify().difference is None


def test_a_recorded_brain_takes_every_change_and_does_not_know_what_was_learned(
    experiment: Path, tmp_path: Path, golden: Golden
) -> None:
    functions = experiment.parent / "functions.py"
    for known in (True, False):
        text = FUNCTIONS.replace("learned.values.mean()", "0.0") if known else FUNCTIONS
        functions.write_text(text)
        folder = tmp_path / f"recording{known}"
        with FilesRead() as files, Run(load_experiment(experiment, ["duration=0.6 s"])) as run:
            recording_folder = RecordingFolder(run, folder, files=files)
            run.run()
            recording_folder.close("finished")
        request = ReplayRequest(recorded=frozenset({"brain"}))
        with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
            if known:
                assert again.verify().difference is None
            else:
                assert "'learned'" in str(again.verify().error)
                golden(str(again.verify().error))


def test_correct_functions_are_met_with_silence(experiment: Path) -> None:
    assert validate_file(experiment) == []


@pytest.mark.parametrize("on_error", ["stop", "quarantine"])
def test_an_impossible_weight_is_an_error_of_its_function(
    experiment: Path, on_error: str, golden: Golden
) -> None:
    path = experiment.parent / "functions.py"
    path.write_text(FUNCTIONS.replace("*= 0.9", "*= 0.9 if t < 0.1 else float('nan')"))
    with Run(load_experiment(experiment, [f"on_error={on_error}"])) as run:
        if on_error == "stop":
            with golden.raises(TransferFunctionRaisedError, match="'fixed'.*'teach'"):
                run.run()
        else:
            run.run()
            assert run.loop.now_ns == S
        assert run.brain.read_weights("set").min() == pytest.approx(0.9**4)


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("old", "new", "backend", "code"),
    [
        ("learned.plastic", "fixed.plastic", "event", "NRP240"),
        ("learned.plastic", "learned.plastic", "spinnaker", "NRP240"),
        ("learned.plastic", "learned.plastics", "event", "NRP240"),
        ('projection("set")', 'projection("sets")', "event", "NRP210"),
        ('projection("set")', "wheels", "event", "NRP211"),
    ],
)
def test_a_mistake_is_found_before_the_run(
    experiment: Path, old: str, new: str, backend: str, code: str
) -> None:
    path = experiment.parent / "functions.py"
    path.write_text(FUNCTIONS.replace(old, new))
    found = [one for one in validate_file(experiment, [f"brain.backend={backend}"]) if one.path == path]
    assert [one.code for one in found] == [Code[code]]
    assert found[0].line is not None


OWN_RULE = """\
law = sim.EquationSynapse(
    "dx/dt = -x/tau : 1", on_pre="x += 1", on_post="weight += rate*x",
    parameters={"tau": "20 ms", "rate": 0.01},
)
rule = law(weight=2.0, delay=1.0)
"""
TENDING = """\
@nrp.MapWeights("w", nrp.brain.projection("learned"))
@nrp.MapCSVRecorder("rows", "own.csv", ["t", "x", "weight"])
@nrp.Robot2Neuron()
def tend(t, w, rows):
    rows.record_entry(t, w.state("x").sum(), w.values.sum())
    if t > 0.3:
        w.set_parameters(rate=0.0 if t > 0.7 else -0.01, tau=5.0)
"""


@pytest.mark.one_of(6)
@MODES
def test_the_state_and_the_parameters_of_equations(
    experiment: Path, tmp_path: Path, options: str, golden: Golden
) -> None:
    """It learns, unlearns and stops; a snapshot and a replay know the changed parameters."""
    begin, end = BRAIN.index("rule ="), BRAIN.index("sim.Projection(eyes")
    (experiment.parent / "brain.py").write_text(BRAIN[:begin] + OWN_RULE + BRAIN[end:])
    (experiment.parent / "functions.py").write_text(TENDING)
    settings, folder = [f"brain.options={options}"], tmp_path / "recording"
    # a mock has no equations, so that the function which reads their state is not checked
    assert [finding.code for finding in validate_file(experiment, settings)] == [Code.NRP239]
    with FilesRead() as files, Run(load_experiment(experiment, settings)) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=S // 4)
        run.run_until(0.6)
        saved = run.snapshot()
        run.run()
        first = rows(run, tmp_path)
        t, x, weight = first.T
        change = np.diff(weight)
        assert change[t[1:] <= 0.3].min() >= 0.0 >= change[(t[1:] > 0.34) & (t[1:] <= 0.7)].max()
        assert weight[t <= 0.3][-1] > 1.1 * weight[0]
        assert weight[-1] < 0.9 * weight[t <= 0.3][-1]
        assert len(np.unique(weight[t > 0.74])) == 1
        assert x[t > 0.5].mean() < 0.5 * x[(t > 0.1) & (t < 0.3)].mean()  # it decays faster
        recording_folder.close("finished")
        run.restore(saved)
        run.run()
        assert rows(run, tmp_path).tolist() == first.tolist()
    for request in (ReplayRequest(), ReplayRequest(from_ns=round(0.62 * S))):
        with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
            assert again.verify().difference is None
    request = ReplayRequest(recorded=frozenset({"brain"}))
    with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
        assert "'learned'" in str(again.verify().error)
        golden(str(again.verify().error))


def test_a_saved_brain_begins_another_run_with_the_learned_weights(
    experiment: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(experiment.parent)
    saved = experiment.with_name("trained.nrpnet")
    request = RunRequest(str(experiment), (), until="1 s", save_brain=saved)
    assert Session(request).run(as_json=True) == 0
    capsys.readouterr()
    with Run(load_experiment(experiment)) as run:
        run.run(1.0)
        learned = {label: run.brain.read_weights(label) for label in ("learned", "set")}
        first = {one.label: one.weight for one in run.brain.network.projections}
    with Run(load_experiment(experiment, [f"brain.model={saved}"])) as again:
        for label, weights in learned.items():
            assert again.brain.read_weights(label).tolist() == weights.tolist() != first[label].tolist()
    with pytest.raises(BadParameter, match=r"trained\.nrpnet"):
        Session(request).run(as_json=True)
