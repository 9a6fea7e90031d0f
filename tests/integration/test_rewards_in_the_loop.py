"""A transfer function rewards: checked, recorded, replayed, restored and reset alike."""

from __future__ import annotations

import csv
from math import exp
from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core._support.used_files import FilesRead
from nrp_core.checks.validate import validate_file
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
eyes = sim.Population(1, sim.SpikeSourceArray(spike_times=[100.0]), label="eyes")
drive = sim.Population(1, sim.SpikeSourceArray(spike_times=[104.0]), label="drive")
critic = sim.Population(1, sim.SpikeSourceArray(spike_times=[]), label="critic")
cells = sim.Population(1, sim.IF_curr_delta(), label="cells")
each = sim.OneToOneConnector()
sim.Projection(drive, cells, each, sim.StaticSynapse(weight=50.0, delay=1.0), label="driving")
rule = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.1, A_minus=0.1),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0),
    weight=2.0,
    delay=1.0,
)
sim.Projection(eyes, cells, each, rule, label="learned")
dopamine = sim.Neuromodulation(weight=0.1, tau_c=1000.0, tau_d=200.0, w_max=20.0)
sim.Projection(critic, cells, each, dopamine, receptor_type="reward", label="rewards")
"""
FUNCTIONS = """\
@nrp.MapReward("reward", nrp.brain.projection("learned"))
@nrp.MapWeights("learned", nrp.brain.projection("learned"))
@nrp.MapCSVRecorder("rows", "weights.csv", ["t", "learned"])
@nrp.Robot2Neuron()
def teach(t, reward, learned, rows):
    if round(t, 3) in (0.2, 0.5):
        reward.value = 0.1 if t < 0.3 else -0.05
    rows.record_entry(t, learned.values[0])
"""
HELD = FUNCTIONS.replace(
    '("learned"))\n@nrp.MapWeights', '("learned"), baseline=4)\n@nrp.MapWeights'
).replace(
    "    rows",
    "    reward.held = 0.002 * (round(50 * t) % 7)\n    rows",
)
"""The same with a held value in each step, and less running means."""
EXPERIMENT = """\
name: rewards
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
LEARNED = 'reward", nrp.brain.projection("learned")'
MODES = pytest.mark.parametrize("options", ["{}", "{resolution: 0.1 ms}"], ids=["exact", "grid"])


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


def expected(t_ms: float) -> float:
    """Return the weight: the target fires at 105 ms, its synapse knows after 1 ms, as of the rewards."""
    weight, fade = 2.0, 1 / 1000 + 1 / 200
    for at, dopamine in ((201.0, 0.1), (501.0, -0.05)):
        left = 0.1 * exp(-6 / 20) * exp(-(at - 106.0) / 1000)
        weight += left * dopamine * (1 - exp(-max(t_ms - at, 0.0) * fade)) / fade
    return weight


@MODES
def test_weights_follow_a_reward_from_its_step_on(experiment: Path, tmp_path: Path, options: str) -> None:
    with Run(load_experiment(experiment, [f"brain.options={options}"])) as run:
        run.run()
        found = rows(run, tmp_path)
    assert found[:, 1] == pytest.approx([expected(1000 * t) for t in found[:, 0]], rel=1e-9)
    assert found[:, 1].max() > 2.5


@MODES
@pytest.mark.parametrize("functions", [FUNCTIONS, HELD], ids=["pulses", "held"])
def test_a_snapshot_and_a_reset_restore_it(
    experiment: Path, tmp_path: Path, options: str, functions: str
) -> None:
    (experiment.parent / "functions.py").write_text(functions)
    with Run(load_experiment(experiment, [f"brain.options={options}"])) as run:
        run.run_until(0.3)
        saved = run.snapshot()
        run.run()
        first, weights = rows(run, tmp_path), run.brain.read_weights("learned").tolist()
        run.restore(saved)
        run.run()
        assert rows(run, tmp_path).tolist() == first.tolist()
        run.reset()
        assert run.brain.read_synapse_state("learned", "dopamine").tolist() == [0.0]
        run.run()
        assert run.brain.read_weights("learned").tolist() == weights


@pytest.mark.one_of(8)
@MODES
@pytest.mark.parametrize("functions", [FUNCTIONS, HELD], ids=["pulses", "held"])
def test_a_replay_is_the_same(experiment: Path, tmp_path: Path, options: str, functions: str) -> None:
    (experiment.parent / "functions.py").write_text(functions)
    folder = tmp_path / "recording"
    with FilesRead() as files, Run(load_experiment(experiment, [f"brain.options={options}"])) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=S // 4)
        run.run()
        recording_folder.close("finished")
    for request in (ReplayRequest(), ReplayRequest(from_ns=round(0.62 * S))):
        with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
            assert again.verify().difference is None


@MODES
def test_held_values_are_less_their_running_mean(experiment: Path, tmp_path: Path, options: str) -> None:
    """The weight follows from the values and the eligibility, after the dendritic delay of 1 ms."""
    pulses = "    if round(t, 3) in (0.2, 0.5):\n        reward.value = 0.1 if t < 0.3 else -0.05\n"
    assert pulses in HELD
    (experiment.parent / "functions.py").write_text(HELD.replace(pulses, ""))
    with Run(load_experiment(experiment, [f"brain.options={options}"])) as run:
        run.run()
        found = rows(run, tmp_path)
    times = [1000 * t for t in found[:, 0]]
    mean, held = 0.0, []
    for t in times:
        reward = 0.002 * (round(t / 20) % 7)
        held.append(reward - mean)
        mean += held[-1] / 4

    def passed(since: float, until: float) -> float:
        """Return the integral of the eligibility of the pair at 106 ms."""
        since, until = max(since, 106.0), max(until, 106.0)
        return 100.0 * exp(-6 / 20) * (exp((106 - since) / 1000) - exp((106 - until) / 1000))

    for now, weight in found * [1000, 1]:
        each = zip(times, held, strict=True)
        changes = [r * passed(min(t + 1, now), min(t + 21, now)) for t, r in each]
        assert weight == pytest.approx(2.0 + sum(changes), rel=1e-9)
    assert abs(found[-1, 1] - 2.0) > 1e-3


def test_a_recorded_brain_takes_rewards(experiment: Path, tmp_path: Path) -> None:
    functions = experiment.parent / "functions.py"
    functions.write_text(FUNCTIONS.replace("learned.values[0]", "0.0"))
    folder = tmp_path / "recording"
    with FilesRead() as files, Run(load_experiment(experiment, ["duration=0.6 s"])) as run:
        recording_folder = RecordingFolder(run, folder, files=files)
        run.run()
        recording_folder.close("finished")
    request = ReplayRequest(recorded=frozenset({"brain"}))
    with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
        assert again.verify().difference is None


@pytest.mark.parametrize("functions", [FUNCTIONS, HELD], ids=["pulses", "held"])
def test_correct_functions_are_met_with_silence(experiment: Path, functions: str) -> None:
    (experiment.parent / "functions.py").write_text(functions)
    assert validate_file(experiment) == []


@pytest.mark.parametrize("on_error", ["stop", "quarantine"])
def test_an_impossible_reward_is_an_error_of_its_function(
    experiment: Path, on_error: str, golden: Golden
) -> None:
    path = experiment.parent / "functions.py"
    path.write_text(FUNCTIONS.replace("-0.05", "float('nan')"))
    with Run(load_experiment(experiment, [f"on_error={on_error}"])) as run:
        if on_error == "stop":
            with golden.raises(TransferFunctionRaisedError):
                run.run()
        else:
            run.run()
            assert run.loop.now_ns == S
        assert run.brain.read_synapse_state("learned", "dopamine")[0] > 0.0


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("file", "old", "new", "backend", "code"),
    [
        ("functions.py", "if round", "reward.values = 0.1\n    if round", "event", "NRP240"),
        ("functions.py", LEARNED, 'reward", nrp.brain.cells', "event", "NRP211"),
        ("functions.py", LEARNED, 'reward", nrp.brain.projection("driving")', "event", "NRP210"),
        ("functions.py", LEARNED, 'reward", nrp.brain.projection("learnt")', "event", "NRP210"),
        ("brain.py", "sim.Projection(critic", "# ", "event", "NRP210"),
    ],
)
def test_a_mistake_is_found_before_the_run(
    experiment: Path, file: str, old: str, new: str, backend: str, code: str
) -> None:
    path = experiment.parent / file
    path.write_text(path.read_text().replace(old, new))
    found = [
        one
        for one in validate_file(experiment, [f"brain.backend={backend}"])
        if one.path and one.path.name == "functions.py"
    ]
    assert [one.code for one in found] == [Code[code]]
    assert found[0].line is not None
