"""The weights of projections over time, as the page plots them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from large_brain import large_brain
from nrp_cockpit.streaming.weights import (
    MOST_STATIC,
    MOST_SYNAPSES,
    ProjectionWeights,
    chosen,
    summary,
    synapses_topic,
    watchable,
    weights_data,
    weights_topic,
)
from visitors import cockpit

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.writing.signals import RecordEntry


def test_the_summary_is_that_of_numpy():
    weights = np.random.default_rng(1).lognormal(size=1001)
    expected = [weights.mean(), *np.percentile(weights, [0, 5, 25, 50, 75, 95, 100])]
    np.testing.assert_allclose(summary(weights), expected)
    many = np.random.default_rng(1).normal(size=1_000_003)
    found = summary(many)
    np.testing.assert_allclose(found[[0, 1, -1]], [many.mean(), many.min(), many.max()])
    np.testing.assert_allclose(found[2:-1], np.percentile(many, [5, 25, 50, 75, 95]), atol=0.05)
    assert np.isnan(summary(np.empty(0))).all()


def test_some_of_many_synapses_have_a_curve():
    assert chosen(3).tolist() == [0, 1, 2]
    assert (len(chosen(1_000_000)), chosen(1_000_000)[-1]) == (MOST_SYNAPSES, 999_999)


def test_weights_are_sent_when_they_change_and_at_most_ten_times_a_second(tmp_path: Path):
    with Run(load_experiment(large_brain(tmp_path, cells=80, packets=1))) as run:
        labels = [each.label for each in watchable(run.brain.network)]
        assert labels == ["next", "kick"]
        signal = ProjectionWeights(run.brain, run.brain.network.projections[0])
        sent: list[RecordEntry] = []
        for step in range(1, 21):
            run.step()
            if step == 12:
                run.brain.set_weights("next", np.linspace(1, 2, 320))
            signal.take(run.loop.now_ns, sent.append)
        both = [weights_topic("next"), synapses_topic("next")]
        assert [entry.topic for entry in sent] == 2 * both
        assert [entry.t_ns / 1e6 for entry in sent] == [20, 20, 300, 300]


def test_only_plastic_ones_of_many_projections_are_offered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with Run(load_experiment(large_brain(tmp_path, cells=80, packets=1))) as run:
        data = list(weights_data(run.brain.network))
        assert {each["unit"] for each in data} == {"nA"}
        described = {each["name"]: each["elements"] for each in data}
        assert described[synapses_topic("kick")] == ["0 to 0"]
        assert MOST_STATIC > 1
        monkeypatch.setattr("nrp_cockpit.streaming.weights.MOST_STATIC", 1)
        assert list(watchable(run.brain.network)) == []


def test_weights_are_read_while_somebody_subscribes_and_no_longer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    experiment = large_brain(tmp_path, cells=80, packets=1)
    with cockpit(experiment=str(experiment)) as opened, opened.visit() as visitor:
        reads: list[str] = []
        real = type(opened.run.brain).read_weights

        def read(brain: object, label: str) -> object:
            reads.append(label)
            return real(brain, label)  # type: ignore[arg-type]

        monkeypatch.setattr(type(opened.run.brain), "read_weights", read)
        visitor.call("step", n=10)
        assert reads == []
        visitor.subscribe(weights_topic("next"))
        visitor.until(lambda: visitor.heard[weights_topic("next")])
        visitor.call("step", n=10)
        assert set(reads) == {"next"}
