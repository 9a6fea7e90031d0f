"""Synapses that release or not: exact means, the same draws in both modes, and streams of their own."""

from __future__ import annotations

from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event.backend import EventBackend
from nrp_brain_spinnaker import SpinnakerBackend

from nrp_core import read_network, save_network
from nrp_core._support.arrays import FloatArray
from nrp_core.brain import builder
from nrp_core.errors import CapabilityError

TIMES_MS = (10.0, 25.0, 30.0, 90.0)
N = 4000
SHORT_TERM = {"U": 0.4, "tau_rec": 40.0, "tau_facil": 60.0}


def network(law: str, parameters: dict[str, float], n: int = N) -> Any:
    """Return one source onto n cells that only add up what arrives."""
    sim = builder()
    sim.setup(timestep=0.1)
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=list(TIMES_MS)))
    cells = sim.Population(n, sim.IF_curr_delta(tau_m=1e9, v_rest=0.0, v_reset=0.0, v_thresh=1e6))
    cells.initialize(v=0.0)
    synapse = getattr(sim, law)(weight=1.0, delay=1.0, **parameters)
    sim.Projection(source, cells, sim.AllToAllConnector(), synapse)
    return sim.network()


def arrived(built: Any, seed: int = 0, resolution: str | None = None) -> FloatArray:
    """Return the share that each spike transmits to each cell, shape ``(n_spikes, n_cells)``."""
    backend, options = EventBackend(), {"resolution": resolution} if resolution else {}
    cells = np.arange(1, built.size)
    with backend.open(built, seed=seed, options=backend.options.model_validate(options)) as brain:
        levels = [brain.read_state("v", cells)]
        for t in TIMES_MS:
            brain.run_until(round((t + 2.0) * 1e6))
            levels.append(brain.read_state("v", cells))
    return np.diff(levels, axis=0)


def mean_shares() -> list[float]:
    """Return the mean share of each spike, from the mean of the filled sites: both are linear."""
    filled, u, last, means = 1.0, 0.0, 0.0, []
    for t in TIMES_MS:
        u = u * exp(-(t - last) / SHORT_TERM["tau_facil"])
        u += SHORT_TERM["U"] * (1.0 - u)
        filled = 1.0 - (1.0 - filled) * exp(-(t - last) / SHORT_TERM["tau_rec"])
        means.append(filled * u)
        filled *= 1.0 - u
        last = t
    return means


@pytest.mark.parametrize(
    ("law", "parameters", "means", "sites"),
    [
        ("SimpleStochasticSynapse", {"p": 0.3}, [0.3] * 4, 1.0),
        ("StochasticTsodyksMarkramSynapse", SHORT_TERM, mean_shares(), 1.0),
        ("MultiQuantalSynapse", {**SHORT_TERM, "n": 5}, mean_shares(), 5.0),
    ],
)
def test_spikes_transmit_the_mean_of_the_law_in_the_same_draws_in_both_modes(
    law: str, parameters: dict[str, float], means: list[float], sites: float
) -> None:
    built = network(law, parameters)
    shares = arrived(built)
    steps = shares * sites
    assert np.abs(steps - np.round(steps)).max() < 1e-6
    error = np.sqrt(np.array(means) * (1.0 - np.array(means)) / (N * sites))
    assert (np.abs(shares.mean(axis=1) - means) < 4.0 * error).all()
    np.testing.assert_allclose(arrived(built, resolution="0.1 ms"), shares, atol=1e-4)
    assert (arrived(built, seed=1) != shares).any()


def test_two_synapses_draw_from_streams_of_their_own() -> None:
    shares = np.round(arrived(network("SimpleStochasticSynapse", {"p": 0.5})))
    both = (shares[0] * shares[1]).mean()
    assert both == pytest.approx(0.25, abs=4.0 * np.sqrt(0.25 * 0.75 / N))
    neighbours = (shares[:, 1:] * shares[:, :-1]).mean()
    assert neighbours == pytest.approx(0.25, abs=4.0 * np.sqrt(0.25 * 0.75 / shares.size))


def test_a_reset_or_restored_brain_draws_the_same_again(tmp_path: Any) -> None:
    built = network("MultiQuantalSynapse", {"n": 3}, n=50)
    save_network(built, tmp_path / "net.nrpnet")
    assert read_network(tmp_path / "net.nrpnet").digest == built.digest
    backend = EventBackend()
    with backend.open(built, seed=3, options=backend.options()) as brain:
        brain.run_until(28_000_000)
        saved = brain.snapshot()
        brain.run_until(100_000_000)
        first = brain.read_state("v", range(1, 51))
        brain.restore(saved)
        brain.run_until(100_000_000)
        assert (brain.read_state("v", range(1, 51)) == first).all()
        brain.reset()
        brain.run_until(100_000_000)
        assert (brain.read_state("v", range(1, 51)) == first).all()


@pytest.mark.parametrize("resolution", [None, "0.1 ms"])
def test_synapses_begin_in_the_state_that_a_script_sets(resolution: str | None, tmp_path: Path) -> None:
    sim = builder()
    sim.setup(timestep=0.1)
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=list(TIMES_MS)))
    cells = sim.Population(3, sim.IF_curr_delta(tau_m=1e9, v_rest=0.0, v_reset=0.0, v_thresh=1e6))
    cells.initialize(v=0.0)
    sites = sim.MultiQuantalSynapse(weight=1.0, delay=1.0, U=1.0, tau_rec=1e9, n=5)
    few = sim.Projection(source, cells[:2], sim.AllToAllConnector(), sites)
    few.initialize(a=[2.0, 5.0])
    tired = sim.TsodyksMarkramSynapse(weight=1.0, delay=1.0, U=0.4, tau_rec=50.0, tau_facil=60.0)
    sim.Projection(source, cells[2:], sim.AllToAllConnector(), tired).initialize(u=0.5, z=0.8)
    built = sim.network()
    save_network(built, tmp_path / "net.nrpnet")
    assert read_network(tmp_path / "net.nrpnet").digest == built.digest
    first, second = arrived(built, resolution=resolution)[:2]
    left = 0.5 * exp(-TIMES_MS[0] / 60.0)
    released = (left + 0.4 * (1.0 - left)) * (1.0 - 0.8 * exp(-TIMES_MS[0] / 50.0))
    assert first == pytest.approx([2 / 5, 1.0, released], rel=1e-6)
    assert second[:2] == pytest.approx([0.0, 0.0], abs=1e-6)  # all sites are empty, and stay so


def test_a_state_at_the_start_is_refused_where_it_has_no_effect(golden: Golden) -> None:
    sim = builder()
    cells = sim.Population(1, sim.IF_curr_exp())
    one = sim.Projection(cells, cells, sim.AllToAllConnector(), sim.TsodyksMarkramSynapse(delay=1.0))
    backend = SpinnakerBackend()
    backend.open(sim.network(), seed=0, options=backend.options()).close()
    one.initialize(u=0.5)
    with golden.raises(CapabilityError):
        backend.open(sim.network(), seed=0, options=backend.options())
