"""What a behaviour needs: the decoder as a regression and as a brain, and the verdict on controls."""

from __future__ import annotations

import json
import os
import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_lab.comparison import evidence
from nrp_lab.comparison.decoder import (
    Decoder,
    DecoderBackend,
    DecoderBrain,
    _lagged,
    ridge,
    thinning,
    with_decoder,
)
from nrp_lab.comparison.evidence import Doing, Evidence, doing_of, evidence_grid
from nrp_lab.comparison.grid import GridCell, RunGrid, _recording_voltages, run_grid
from nrp_lab.comparison.judgement import Contrast, Estimate, Factor, Relation, holm
from nrp_lab.comparison.metric import Margins
from nrp_lab.comparison.result import GridDiff
from nrp_lab.comparison.signals import RunSignals

from nrp_core import InvalidExperimentError
from nrp_core.brain import (
    BrainCapabilities,
    BrainOptions,
    Network,
    NoisyCurrentSource,
    Population,
    StateRecorderPort,
    VoltageRecorder,
)
from nrp_core.dsl import spike_recorder
from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.experiment import Plan, Run
from nrp_core.experiment.model.experiment import VoltageSection
from nrp_core.network.cells import CELLS

BRAIN = """
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
senders = sim.Population(10, sim.IF_curr_exp(), label="senders")
targets = sim.Population(10, sim.IF_curr_exp(), label="targets")
synapse = sim.StaticSynapse(weight=30.0, delay=1.0)
used = sim.PopulationView(senders, range(5), label="used")
sim.Projection(used, targets, sim.AllToAllConnector(), synapse, label="used")
others = sim.Population(10, sim.IF_curr_exp(), label="others")
sim.Projection(senders[5:], others, sim.AllToAllConnector(), synapse, label="other")
"""
FUNCTIONS = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64


@nrp.MapSpikeSource("drive", nrp.brain.senders, nrp.dc_source, amplitude=0.0)
@nrp.Robot2Neuron()
def push(t, drive):
    drive.amplitude = 2.0 if t > 0.015 else 0.0


@nrp.MapSpikeSink("rate", nrp.brain.targets, nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/rate", Float64))
def publish(t, rate):
    return Float64(rate.rate)
"""
EXPERIMENT = """
name: pushed
timestep: 10 ms
duration: 60 ms
seed: 1
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
transfer_functions: [functions.py]
topics: {/rate: std_msgs/Float64}
criteria:
  targets_fire: {topic_stays: {name: /rate, above: 1, during: {since: 50 ms}}}
"""
ROOM = '<sdf version="1.6"><world name="room"/></sdf>'


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), lags=st.integers(1, 5))
def test_a_linear_map_with_lags_is_found(seed: int, lags: int) -> None:
    rng = np.random.default_rng(seed)
    given_inputs, weights = rng.normal(size=(200, 3)), rng.normal(size=(lags * 3, 2))
    inputs = _lagged(given_inputs, lags)
    assert (inputs[:, :3] == given_inputs).all()
    assert (inputs[lags:, -3:] == given_inputs[1 : 201 - lags]).all()
    values = inputs @ weights + [1.0, -2.0]
    found, offsets, explained = ridge(inputs, values)
    np.testing.assert_allclose(found, weights, atol=1e-3)
    np.testing.assert_allclose(offsets, [1.0, -2.0], atol=1e-3)
    np.testing.assert_allclose(explained, 1.0, atol=1e-6)


def test_noise_is_not_decoded() -> None:
    rng = np.random.default_rng(0)
    _, _, explained = ridge(rng.normal(size=(300, 100)), rng.normal(size=(300, 1)))
    assert explained[0] < 0.2  # without the penalty a third


def test_a_value_is_decoded_as_well_beside_one_in_another_unit() -> None:
    rng = np.random.default_rng(0)
    inputs, noise = rng.normal(size=(300, 100)), rng.normal(size=(300, 1))
    found = [ridge(inputs, np.hstack([unit * inputs[:, :1], noise]))[2] for unit in (1e-3, 1.0, 1e3)]
    np.testing.assert_allclose(found[1:], found[:-1], atol=1e-6)


def test_constant_values_do_not_count_as_explained() -> None:
    rng, none = np.random.default_rng(0), np.zeros(0)
    noise = rng.normal(size=(300, 1))
    explained = ridge(rng.normal(size=(300, 2)), np.hstack([noise, np.ones((300, 2))]))[2]
    decoder = Decoder({}, {"varied": 2, "constant": 1}, {}, 1, none, none, none, none, explained)
    assert decoder.explained_by_sink == {"varied": pytest.approx(explained[0]), "constant": 1.0}
    assert explained[0] < 0.1


def test_steps_are_left_out_of_a_fit_that_would_not_fit_in_memory() -> None:
    inputs = np.arange(20.0).reshape(10, 2)
    np.testing.assert_array_equal(_lagged(inputs, 3, 4), _lagged(inputs, 3)[::4])
    assert thinning(1000, 200) == 1
    assert thinning(200_000, 1000) == 10
    with pytest.raises(ExperimentError, match="30000"):
        thinning(1000, 30_000)


def test_a_decoder_does_not_stand_in_for_spikes_and_changes_nothing() -> None:
    reads = SimpleNamespace(name="count", mappings={"spikes": SimpleNamespace(kind=spike_recorder)})
    with pytest.raises(ExperimentError, match=r"'count'.*'spikes'"):
        with_decoder(cast(Plan, SimpleNamespace(functions=[reads])), cast(Decoder, None))
    assert not decoder_brain().capabilities.changes


D, E, U = Relation.DIFFERENT, Relation.EQUIVALENT, Relation.OPEN


@pytest.mark.parametrize(
    ("controls", "doing"),
    [
        ({"rewire: degree_preserving": D, "shuffle: signs": U, "decoder alone": D}, Doing.WIRING),
        ({"rewire: degree_preserving": D, "decoder alone": E}, Doing.DECODER),
        ({"rewire: degree_preserving": D, "decoder alone": U}, Doing.OPEN),
        ({"rewire: degree_preserving": D, "decoder alone": E, "world: pybullet": D}, Doing.SIMULATOR),
        ({"rewire: degree_preserving": D, "decoder alone": D, "timestep: 10 ms": D}, Doing.SIMULATOR),
        ({"rewire: degree_preserving": E, "shuffle: weights": E, "decoder alone": D}, Doing.BRAIN),
        ({"rewire: degree_preserving": U, "decoder alone": D}, Doing.OPEN),
        ({"silence: MN9": D, "decoder alone": D}, Doing.OPEN),
        ({"rewire: degree_preserving": D}, Doing.OPEN),
        ({}, Doing.OPEN),
    ],
)
def test_the_verdict_follows_from_the_controls(controls: dict[str, Relation], doing: Doing) -> None:
    assert doing_of([controls]) is doing


def test_one_part_must_need_the_wiring_and_more_than_the_decoder() -> None:
    kept, shaped, slower = {"rewire": D, "decoder alone": E}, {"rewire": D, "decoder alone": D}, {
        "rewire": E, "decoder alone": D,
    }  # fmt: skip
    assert doing_of([kept, slower]) is Doing.BRAIN
    assert doing_of([kept, shaped, slower]) is Doing.WIRING
    assert doing_of([kept, {"rewire": D, "decoder alone": U}]) is Doing.OPEN


@pytest.mark.parametrize(("is_finding", "doing"), [(True, Doing.WIRING), (False, Doing.OPEN)])
def test_only_criteria_and_events_need_the_wiring(is_finding: bool, doing: Doing) -> None:
    contrasts = [
        Contrast(Factor.WIRING, "original", other, Estimate(1.0, 0.1, 7), 9.0, 0.001)
        for other in ("rewire", "decoder alone")
    ]
    part = SimpleNamespace(margin=0.1, contrasts=contrasts)
    judged = SimpleNamespace(metric=SimpleNamespace(is_finding=is_finding), parts=[part])
    found = Evidence(cast(GridDiff, SimpleNamespace(finding=[judged], runs={})))
    assert found.doing is doing
    assert ("no criteria" in found.sentence) is not is_finding
    assert ("linear decoder" in found.sentence) is is_finding
    partial = replace(found, left_out={"shuffle: signs": "all excite"}, without_decoder="no sink")
    rest = found.sentence[0].lower() + found.sentence[1:]
    assert partial.sentence == f"Compared without 'shuffle: signs' and 'decoder alone', {rest}"


@settings(max_examples=30, deadline=None)
@given(values=st.lists(st.integers(-1, 1), min_size=2, max_size=9), times=st.integers(2, 5))
def test_an_estimate_is_scaled_as_if_all_seeds_came_again(values: list[int], times: int) -> None:
    some, all_seeds = np.array(values, float), np.array(values * times, float)
    found, wanted = Estimate.from_matched_shares(some).scaled(times), Estimate.from_matched_shares(all_seeds)
    np.testing.assert_allclose([found.mean, found.error], [wanted.mean, wanted.error], atol=1e-12)
    found, wanted = Estimate.of(some).scaled(times), Estimate.of(all_seeds)
    assert (found.mean, found.freedom) == (pytest.approx(wanted.mean, abs=1e-12), wanted.freedom)
    spread = len(some) * times
    assert found.error**2 * (len(some) - 1) * times == pytest.approx(
        wanted.error**2 * (spread - 1), abs=1e-12
    )


def alike(n_seeds: int) -> Evidence:
    """Return evidence in which a criterion fails with two controls and each of some seeds."""
    estimate = Estimate.from_matched_shares(np.full(n_seeds, -1.0))
    p_different = holm([estimate.p_different] * 2)[0]
    contrasts = [
        Contrast(Factor.WIRING, "original", other, estimate, 1.0, p_different)
        for other in ("rewire", "decoder alone")
    ]
    part = SimpleNamespace(margin=0.1, contrasts=contrasts)
    judged = SimpleNamespace(metric=SimpleNamespace(is_finding=True), parts=[part])
    grid = SimpleNamespace(seeds=range(n_seeds))
    return Evidence(cast(GridDiff, SimpleNamespace(finding=[judged], runs={}, grid=grid)))


def test_the_number_of_seeds_that_would_decide_decides() -> None:
    needed = alike(2).seeds_to_decide
    assert needed is not None
    assert [alike(n).doing for n in range(2, needed + 2)] == [Doing.OPEN] * (needed - 2) + [Doing.WIRING] * 2
    assert alike(needed).seeds_to_decide is None
    assert alike(1).seeds_to_decide is None


def test_two_animals_of_one_name_are_refused() -> None:
    def controls(*animals: str) -> tuple[str, ...]:
        return evidence_grid(
            "braitenberg_husky", ["rewire: degree_preserving"], {"animal": animals}, 2, (), {}
        ).wirings

    assert controls("a/fly.nrpnet", "a/fly.nrpnet", "worm.nrpnet")[-2:] == (
        "animal: fly.nrpnet",
        "animal: worm.nrpnet",
    )
    with pytest.raises(ExperimentError, match=r"fly\.nrpnet"):
        controls("a/fly.nrpnet", "b/fly.nrpnet")


def test_the_page_has_the_command_that_makes_its_runs() -> None:
    others = {"animal": ["one.nrpnet", "two.nrpnet"], "world": ["mujoco", "pybullet"], "timestep": ["10 ms"]}
    controls = "rewire: degree_preserving", "silence: sensors"
    grid = evidence_grid("braitenberg_husky", controls, others, 3, ["duration=9 s"], {})
    made, left_out = (
        replace(grid, wirings=tuple(set(grid.wirings) - {controls[1]})),
        {controls[1]: "it has none"},
    )
    found = shlex.split(Evidence(cast(GridDiff, SimpleNamespace(grid=made)), "", left_out).command)
    assert found[:6] == ["nrp", "diff", "braitenberg_husky", "--evidence", "--seeds", "3"]
    pairs = list(zip(found[6::2], found[7::2], strict=True))
    assert pairs == [
        ("--controls", ", ".join(controls)),
        ("--animal", str(Path("one.nrpnet").resolve())), ("--animal", str(Path("two.nrpnet").resolve())),
        ("--worlds", "pybullet"), ("--timesteps", "10 ms"),
        ("--vary", "events.left_red.at=4..10 s"), ("-s", "duration=9 s"),
    ]  # fmt: skip


def test_a_decoder_that_cannot_run_leaves_the_other_controls(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = evidence_grid("braitenberg_husky", ["rewire: degree_preserving"], {}, 2, (), {})

    def run(asked: RunGrid, *_: object) -> dict[GridCell, RunSignals]:
        if asked.decoders:
            raise CapabilityError("no voltage")
        return {}

    monkeypatch.setattr(evidence, "run_grid", run)
    monkeypatch.setattr(evidence, "_decoders", lambda _: {1: "a decoder"})
    monkeypatch.setattr(GridDiff, "of", lambda grid, *_: SimpleNamespace(grid=grid))
    found = evidence.gather(grid, Path(), 1, lambda *_: None, (), Margins())
    assert found.without_decoder == "no voltage"
    assert found.diff.grid == grid


def test_a_control_that_a_network_does_not_allow_leaves_the_others(tmp_path: Path) -> None:
    controls = ["rewire: degree_preserving", "shuffle: weights", "silence: sensors"]
    left_out = dict[str, str]()
    grid = evidence_grid("braitenberg_husky", controls, {}, 1, ["duration=20 ms"], {})
    runs = run_grid(grid, tmp_path, 1, lambda *_: None, left_out)
    assert [cell.wiring for cell in runs] == ["original", controls[2]]
    assert list(left_out) == [*controls[:2], "silence_matched: sensors"]
    assert all(f"'{name}'" in left_out[name] for name in controls[:2])
    assert "brain.controls" not in left_out[controls[0]]  # nobody wrote that override
    with pytest.raises(InvalidExperimentError):
        run_grid(grid, tmp_path, 1, lambda *_: None)


def test_voltages_that_functions_read_are_recorded_beside_those_that_the_file_names() -> None:
    port = StateRecorderPort.__new__(StateRecorderPort)
    port.__dict__.update(neurons=np.array([2, 4]), _spec=VoltageRecorder())
    ids = {"all": np.arange(2), "some": np.arange(2, 5), "none": np.arange(5, 7)}
    network = SimpleNamespace(populations=ids, ids_of=ids.get)

    def recorded(**voltages: VoltageSection) -> object:
        brain = SimpleNamespace(devices=[port], network=network)
        experiment = SimpleNamespace(recording=SimpleNamespace(voltages=voltages), timestep=20)
        (text,) = _recording_voltages(cast(Run, SimpleNamespace(brain=brain, experiment=experiment))) or [""]
        return json.loads(text.removeprefix("recording.voltages=") or "0")

    whole = VoltageSection(interval="5 ms")
    assert recorded() == {"some": {"cells": [0, 2], "interval": "20 ns"}}
    assert recorded(some=whole) == 0
    assert recorded(some=VoltageSection(cells=(0, 2))) == 0
    assert recorded(all=whole, some=VoltageSection(cells=(1, 2), interval="5 ms")) == {
        "all": {"interval": "5000000 ns"}, "some": {"cells": [0, 1, 2], "interval": "5000000 ns"},
    }  # fmt: skip


def decoder_brain() -> DecoderBrain:
    """Return a decoder with 3 steps of history of the mean of one noisy current."""
    cell = CELLS["IF_curr_exp"]
    parameters, state = (
        {name: np.full(1, one.default) for name, one in known.items()}
        for known in (cell.parameters, cell.state)
    )
    population = Population("cells", 1, "IF_curr_exp", parameters, state)
    zero = np.zeros(1)
    one, topic = np.ones(1), "/brain/cells/voltages"
    decoder = Decoder(
        {"/brain/devices/noise/mean": 1}, {topic: 1}, {topic: ("cells", np.array([0]))}, 3,
        np.array([[0.0], [1.0], [0.0]]), zero, zero, 9.0 * one, one,
    )  # fmt: skip
    brain = DecoderBackend(
        decoder,
        BrainCapabilities(
            frozenset({"IF_curr_exp"}),
            frozenset(),
            changes=frozenset({"weights"}),
            state_variables=frozenset({"v", "gsyn_exc"}),
        ),
    ).open(Network({"cells": population}), seed=0, options=BrainOptions())
    assert isinstance(brain, DecoderBrain)
    return brain


def test_the_history_shifts_once_a_step_of_the_loop_with_noise() -> None:
    brain = decoder_brain()
    noise = brain.add_source(NoisyCurrentSource(mean=1.0), [0], name="noise")
    for step in (1, 2):
        setattr(noise, "mean", float(step))  # noqa: B010  a source in general has no mean
        brain.run_until(step * 20_000_000)
    np.testing.assert_array_equal(brain._history.ravel(), [2.0, 1.0, 0.0])


def test_a_decoder_shows_the_voltages_that_it_predicts() -> None:
    brain = decoder_brain()  # it predicts the mean of the noise one step before
    recorder = brain.add_sink(VoltageRecorder(dt=10.0), [0], name="v")
    noise = brain.add_source(NoisyCurrentSource(mean=1.0), [0], name="noise")
    for step in (1, 2, 3):
        setattr(noise, "mean", float(step))  # noqa: B010
        brain.run_until(step * 20_000_000)
    assert isinstance(recorder, StateRecorderPort)
    times_ms, voltages = recorder.samples()
    np.testing.assert_array_equal(times_ms, [0, 10, 20, 30, 40, 50, 60])
    np.testing.assert_array_equal(voltages[1:, 0], [0, 0, 1, 1, 2, 2])
    assert brain.capabilities.state_variables == {"v"}


@pytest.mark.heavy
def test_the_evidence_of_a_push_that_a_decoder_explains(
    tmp_path: Path, nrp: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    files = {"brain.py": BRAIN, "functions.py": FUNCTIONS, "pushed.yaml": EXPERIMENT, "room.sdf": ROOM}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    arguments = "--evidence", "--seeds", 8, "--jobs", 1, "--controls", "silence: used", "--timesteps", "20 ms"
    told = nrp("diff", "pushed.yaml", *arguments, "--json")
    assert told.code == 0, told.err
    found = json.loads(told.out)
    assert found["doing"] == "decoder"
    assert found["controls"] == {
        "silence: used": "different", "silence_matched: used": "equivalent", "timestep: 20 ms": "equivalent",
        "decoder alone": "equivalent",
    }  # fmt: skip
    assert {name: len(folders) for name, folders in found["recordings"].items()} == dict.fromkeys(
        ["original", *found["controls"]], 8
    )
    page = Path(found["page"]).read_text()
    assert "The behaviour needs only the decoder" in page
    assert not re.search(r"""(src|href)=["']https?:|url\(http|@import""", page)  # it needs no network
    first, *others = (Path(os.path.relpath(one)) for one in found["recordings"]["decoder alone"])
    player = first.with_name(f"{first.name}.html")
    assert player.stat().st_size < 6e6
    assert all(f'href="{one}"' in page for one in (player, *others))
    alone = nrp("diff", "pushed.yaml", "--animal", "other.nrpnet", "--engines")
    assert alone.code == 2


@pytest.mark.heavy
def test_a_head_that_follows_a_ball_needs_only_the_decoder(
    tmp_path: Path, nrp: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shorter = "-s", "duration=3 s", "--seeds", 8, "--jobs", 2, "--controls", "rewire"
    found = json.loads(nrp("diff", "following_head", "--evidence", *shorter, "--json").out)
    assert found["doing"] == "decoder"
    assert found["controls"] == {"rewire: degree_preserving": "different", "decoder alone": "equivalent"}
