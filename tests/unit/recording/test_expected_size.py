"""The size of a recording is estimated from its sources before the run."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest

import nrp_core
from nrp_core.network.data import Population
from nrp_core.recording.folder.expected_size import LARGE_BYTES, expected_spikes, size_note

NOISE = """\
import nrp_core.pynn as sim

sim.setup(timestep=1.0)
noise = sim.Population(10, sim.SpikeSourcePoisson(rate=100.0, start=100.0, duration=500.0), label="noise")
cells = sim.Population(10, sim.IF_curr_exp(i_offset=1.0), label="cells")
"""
LAB = """\
name: lab
duration: 1 s
brain: {backend: event, model: noise.py}
world: {backend: mujoco, scene: room.sdf}
"""
ROOM = '<sdf version="1.9"><world name="r"><include><uri>model://ground_plane</uri></include></world></sdf>'


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    for name, text in {"noise.py": NOISE, "lab.yaml": LAB, "room.sdf": ROOM}.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "lab.yaml"


def poisson(rate: float, start: float, duration: float) -> Population:
    own = {"rate": rate, "start": start, "duration": duration}
    return Population("p", 4, "SpikeSourcePoisson", {key: np.full(4, value) for key, value in own.items()})


@pytest.mark.parametrize(
    ("population", "spikes"),
    [
        (poisson(50.0, 0.0, 1e10), 4 * 50 * 2.0),
        (poisson(50.0, 1500.0, 200.0), 4 * 50 * 0.2),
        (poisson(50.0, 3000.0, 1e10), 0.0),
        (Population("p", 2, "SpikeSourceArray", {}, spike_times_ms=(np.arange(5e3), np.zeros(1))), 2001),
        (Population("p", 2, "IF_curr_exp", {"i_offset": np.ones(2)}), 0.0),
    ],
)  # fmt: skip
def test_sources_have_their_number_of_spikes(population: Population, spikes: float) -> None:
    assert expected_spikes(population, 0.0, 2.0) == pytest.approx(spikes)


def test_the_estimate_is_what_a_simulator_sends(lab: Path) -> None:
    with nrp_core.open_run(lab) as run:
        run.run()
        noise = run.brain.network.populations["noise"]
        expected = expected_spikes(noise, 0.0, 1.0)
        assert abs(run.spikes["noise"] - expected) < 4 * expected**0.5  # of a Poisson process


def test_a_large_recording_is_announced_before_the_run_and_no_other(
    lab: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    with caplog.at_level(logging.WARNING):
        nrp_core.run(lab, record=tmp_path / "small")
    assert not caplog.records
    with nrp_core.open_run(lab, ["duration=100 s"]) as run:
        assert size_note(run) is None
        monkeypatch.setattr("nrp_core.recording.folder.expected_size.LARGE_BYTES", LARGE_BYTES / 1e5)
        assert "recording.exclude=[noise]" in str(size_note(run))
        assert size_note(run, 0.2) is None
    with nrp_core.open_run(lab, ["recording.exclude=[noise]"]) as run:
        assert size_note(run) is None
    with caplog.at_level(logging.WARNING):
        nrp_core.run(lab, record=tmp_path / "large")
    assert [record.name for record in caplog.records] == ["nrp_core.running"]
