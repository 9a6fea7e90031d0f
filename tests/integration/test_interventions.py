"""Cells are silenced, lesioned, scaled and activated in a running experiment; its wiring is controlled."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import ExperimentError
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, InvalidExperimentError, Level

BRAIN = """
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
circuit = sim.Population(6, sim.IF_curr_exp(i_offset=[0.9, 0.9, 0.0, 0.0, 0.0, 0.0]), label="circuit")
both = [(0, 2, 8.0, 1.0), (1, 3, 8.0, 1.0), (2, 4, 8.0, 1.0), (3, 5, 8.0, 1.0)]
sim.Projection(circuit, circuit, sim.FromListConnector(both), label="chain")
"""
UNTIL_S, HALF_MS = 0.4, 200.0


@pytest.fixture
def brain(tmp_path: Path) -> str:
    path = tmp_path / "brain.py"
    path.write_text(BRAIN)
    return str(path)


def experiment_of(brain: str, *settings: str) -> Experiment:
    own = [
        f"brain.model={brain}",
        "brain.populations={sensors: null, actors: null, driver: 1, relay: 3, last: 5}",
        "transfer_functions=[]", "aliases=null", "events=null", "criteria=null", "comparison.vary=null",
        "world.options.image_scale=0.1", "duration=1 s", "brain.backend=spinnaker", *settings,
    ]  # fmt: skip
    return load_experiment("braitenberg_husky", own)


def opened(brain: str, *settings: str) -> Run:
    return Run(experiment_of(brain, *settings))


def fired(run: Run, until_s: float = UNTIL_S) -> dict[int, np.ndarray]:
    """Return the spike times of each cell, ms."""
    from nrp_core.brain import SpikeRecorder

    recorder = run.brain.add_sink(SpikeRecorder(), np.arange(6), name="all")
    run.run_until(until_s)
    spikes = recorder.spikes()  # type: ignore[attr-defined]
    return {cell: spikes.times_ms[spikes.neurons == cell] for cell in range(6)}


def counts(brain: str, *settings: str) -> list[int]:
    with opened(brain, *settings) as run:
        return [len(times) for times in fired(run).values()]


def test_a_silenced_relay_fires_without_effect_and_a_lesioned_one_gets_no_input(brain: str) -> None:
    whole = counts(brain)
    assert min(whole) > 5
    silenced = counts(brain, "brain.interventions=[{silence: relay}]")
    assert silenced == [*whole[:5], 0]
    lesioned = counts(brain, "brain.interventions=[{lesion: relay}]")
    assert lesioned == [*whole[:3], 0, whole[4], 0]


def test_a_cut_during_the_run_acts_from_its_time_on_and_is_an_event(brain: str) -> None:
    with opened(brain) as run:
        whole = fired(run)
    with opened(brain, "brain.interventions=[{silence: driver, at: 200 ms}]") as run:
        cut = fired(run)
        assert run.result().events["silence_driver"] == 0.2
    for cell in (0, 1, 2, 4):
        assert cut[cell].tolist() == whole[cell].tolist()
    for cell in (3, 5):
        assert cut[cell].tolist() == whole[cell][whole[cell] < cut[cell].max() + 0.01].tolist()
        assert HALF_MS - 40.0 < cut[cell].max() < HALF_MS + 15.0


def test_a_cut_outlasts_a_reset_of_the_brain_and_a_snapshot_knows_it(brain: str) -> None:
    with opened(brain, "brain.interventions=[{scale: {sources: driver, by: 0}, at: 100 ms}]") as run:
        run.run_until(0.08)
        early = run.snapshot()
        run.run_until(0.2)
        late = run.snapshot()
        run.reset("brain")
        assert len(fired(run, 0.5)[3]) == 0
    with opened(brain, "brain.interventions=[{scale: {sources: driver, by: 0}, at: 100 ms}]") as run:
        run.restore(late)
        assert run.brain.read_weights("chain").tolist() == [8.0, 0.0, 8.0, 8.0]
        run.restore(early)
        assert run.brain.read_weights("chain").tolist() == [8.0, 8.0, 8.0, 8.0]
        run.run_until(0.2)
        assert run.brain.read_weights("chain").tolist() == [8.0, 0.0, 8.0, 8.0]


def test_activated_cells_fire_while_they_are_driven(brain: str) -> None:
    drive = "{cells: last, rate: 2 kHz, weight: 3, duration: 100 ms}"
    cut = "{lesion: relay}, {silence: driver}"
    with opened(brain, f"brain.interventions=[{cut}, {{activate: {drive}, at: 200 ms}}]") as run:
        times = fired(run)[5]
    assert len(times) > 5
    assert times.min() > HALF_MS
    assert times.max() < HALF_MS + 120.0


def test_a_negative_weight_inhibits_cells_with_conductances(tmp_path: Path) -> None:
    path = tmp_path / "brain.py"
    path.write_text(BRAIN.replace("IF_curr_exp", "IF_cond_exp").replace("8.0", "0.1"))
    drive = "{cells: driver, rate: 2 kHz, weight: -0.05}"
    assert counts(str(path))[1] > 5
    assert counts(str(path), f"brain.interventions=[{{activate: {drive}}}]")[1] == 0


def test_a_control_is_a_variant_of_the_experiment(brain: str) -> None:
    """The digest of the network tells the variants apart, and each is the same every time."""

    def digest(*settings: str) -> str:
        with opened(brain, *settings) as run:
            return run.brain.network.digest

    rewired = "brain.controls=[{rewire: degree_preserving}]"
    assert digest(rewired) == digest(rewired) != digest()
    assert digest(rewired) != digest(rewired, "seed=8")
    silent = "[{silence: relay}]"
    assert digest(f"brain.controls={silent}") == digest(f"brain.interventions={silent}") != digest()


@pytest.mark.parametrize(
    "setting",
    [
        "interventions=[{silence: realy}]",
        "interventions=[{activate: {cells: x, rate: 3 Hz, weight: 1}}]",
        "interventions=[{silence: relay, lesion: last}]",
        "interventions=[{scale: {by: 2}}]",
        "interventions=[{scale: {sources: relay, by: -1}}]",
        "controls=[{rewire: degrees}]",
        "interventions=[{activate: {cells: relay, rate: -3 Hz, weight: 1}}]",
        "controls=[{}]",
        "controls=[{silence: realy}]",
    ],
)
def test_a_mistake_is_one_clear_error(brain: str, setting: str, golden: Golden) -> None:
    with golden.raises(ExperimentError), opened(brain, f"brain.{setting}"):
        pass


FIXED = """
import pyNN.spiNNaker as p

p.setup(1.0)
circuit = p.Population(6, p.IF_curr_exp(), label="circuit")
teacher = p.Population(1, p.IF_curr_exp(), label="teacher")
law = p.STDPMechanism(p.SpikePairRule(), p.AdditiveWeightDependence(), weight=0.5)
p.Projection(circuit, circuit, p.OneToOneConnector(), law, label="learns")
dopamine = p.extra_models.Neuromodulation(0.05)
p.Projection(teacher, circuit, p.AllToAllConnector(), dopamine, receptor_type="reward", label="good")
"""


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ("circuit", "'silence_circuit'.*'learns'"),
        ("teacher", "'silence_teacher'.*'good'"),
    ],
)
def test_a_cut_during_the_run_of_weights_that_cannot_be_set_is_a_mistake(
    brain: str, cells: str, message: str, golden: Golden
) -> None:
    Path(brain).write_text(FIXED)
    later = f"brain.interventions=[{{silence: {cells}, at: 0.1 s}}]"
    with golden.raises(ExperimentError, match=message), opened(brain, later):
        pass


def warnings_of(brain: str, settings: Sequence[str]) -> list[str]:
    with opened(brain, *settings) as run:
        return [str(one) for one in run.result().problems]


def test_an_unknown_name_is_a_mistake_of_its_intervention(brain: str) -> None:
    settings = "brain.interventions=[{silence: relay}, {silence: realy}]"
    with pytest.raises(InvalidExperimentError) as raised, opened(brain, settings):
        pass
    (finding,) = raised.value.findings
    assert (finding.code, finding.level) == (Code.NRP202, Level.ERROR)


def test_an_intervention_that_meets_no_synapse_is_a_warning(brain: str) -> None:
    found = warnings_of(brain, ["brain.interventions=[{silence: last}]"])
    assert any("'silence_last' affects no synapse [NRP279]" in one for one in found)


IDLE = [
    (
        "interventions=[{silence: relay, at: 1 s}]",
        "'silence_relay' has no effect: it acts at 1 s, and the run ends",
    ),
    (
        "interventions=[{scale: {sources: relay, by: 1}}]",
        "has no effect: it multiplies weights by 1",
    ),
    (
        "interventions=[{activate: {cells: last, rate: 0 Hz, weight: 3}}]",
        "it sends 0 spikes a second of weight 3",
    ),
    (
        "interventions=[{activate: {cells: last, rate: 9 Hz, weight: 0}}]",
        "it sends 9 spikes a second of weight 0",
    ),
    (
        "interventions=[{lesion: relay}, {activate: {cells: relay, rate: 9 Hz, weight: 3}}]",
        "'activate_relay' has no effect: other interventions have cut all these synapses",
    ),
    (
        "interventions=[{silence: relay, at: 200 ms}, {scale: {sources: relay, by: 2}, at: 400 ms}]",
        "'scale_relay' has no effect: other interventions have cut all these synapses",
    ),
    ("interventions=[{silence: relay, at: 400 ms}, {scale: {sources: relay, by: 2}, at: 200 ms}]", ""),
    ("interventions=[{silence: relay, at: 400 ms}, {activate: {cells: relay, rate: 9 Hz, weight: 3}}]", ""),
    ("interventions=[{silence: relay, at: 980 ms}]", ""),
    ("interventions=[{scale: {sources: relay, by: 1.1}}]", ""),
    ("controls=[{rewire: degree_preserving}]", ""),
]


@pytest.mark.parametrize(("setting", "words"), IDLE)
def test_a_variant_that_changes_nothing_is_a_warning(brain: str, setting: str, words: str) -> None:
    plan = prepare(experiment_of(brain, f"brain.{setting}", "brain.backend=event"))
    found = [one.message for one in plan.warnings if one.code is Code.NRP279]
    assert [words in one for one in found] == [True] * bool(words)


@pytest.mark.parametrize("control", ["shuffle: weights", "shuffle: signs", "silence: last"])
def test_a_control_that_changes_no_synapse_is_an_error(brain: str, control: str) -> None:
    """Otherwise the finding would be kept, and would seem not to depend on the wiring."""
    with pytest.raises(InvalidExperimentError) as caught:
        prepare(experiment_of(brain, f"brain.controls=[{{{control}}}]", "brain.backend=event"))
    assert [(one.code, f"'{control}'" in one.message) for one in caught.value.findings] == [
        (Code.NRP202, True)
    ]
