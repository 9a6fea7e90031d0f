"""Weights that are set in every step give postsynaptic potentials of these heights, on every backend.

The potential of an exponential current of weight w is, for t after its arrival,
``w tau_m tau_s / (C (tau_m - tau_s)) (exp(-t / tau_m) - exp(-t / tau_s))`` (Rotter & Diesmann 1999).
"""

from __future__ import annotations

import numpy as np
import pytest
from nrp_brain_event import EventBackend
from nrp_brain_spinnaker import SpinnakerBackend

from nrp_core.brain.backend import BrainBackend
from nrp_core.clock import from_milliseconds
from nrp_core.network.pynn import builder

TAU_M, TAU_S, C, REST = 20.0, 5.0, 1.0, -65.0
PERIOD_MS, STEPS = 20.0, 12
FIRST_MS = (4.0, 9.0)
"""When the two sources fire in each step, ms; the delay is 1 ms."""


def potential(weights: np.ndarray, t_ms: float) -> float:
    """Return the voltage above rest at a time: the sum over all spikes, each with the weight of its step."""
    total = 0.0
    for step, pair in enumerate(weights):
        for weight, first_ms in zip(pair, FIRST_MS, strict=True):
            after = t_ms - (step * PERIOD_MS + first_ms + 1.0)
            if after > 0:
                decays = np.exp(-after / TAU_M) - np.exp(-after / TAU_S)
                total += weight * TAU_M * TAU_S / (C * (TAU_M - TAU_S)) * decays
    return total


@pytest.mark.parametrize(
    ("backend", "options", "within_mv"),
    [
        (EventBackend(), {}, 1e-9),
        (EventBackend(), {"resolution": "1 ms", "lazy": "never"}, 1e-6),
        (EventBackend(), {"resolution": "1 ms", "lazy": "always"}, 1e-6),
        (SpinnakerBackend(), {"timestep": "1 ms"}, 0.03),
    ],
    ids=["exact", "grid", "lazy", "spinnaker"],
)
def test_each_potential_has_the_height_of_the_weight_of_its_step(
    backend: BrainBackend, options: dict[str, object], within_mv: float
) -> None:
    sim = builder()
    times = [[first_ms + PERIOD_MS * step for step in range(STEPS)] for first_ms in FIRST_MS]
    pair = sim.Population(2, sim.SpikeSourceArray(spike_times=times), label="pair")
    parameters = {"tau_m": TAU_M, "cm": C, "tau_syn_E": TAU_S, "v_rest": REST, "v_thresh": 0.0}
    cell = sim.Population(1, sim.IF_curr_exp(**parameters), label="cell")
    cell.initialize(v=REST)
    sim.Projection(pair, cell, sim.AllToAllConnector(), sim.StaticSynapse(weight=3.0, delay=1.0), label="p")
    weights = np.random.default_rng(2).uniform(0.0, 3.0, (STEPS, 2))
    with backend.open(sim.network(), seed=1, options=backend.options.model_validate(options)) as brain:
        for step, both in enumerate(weights):
            brain.set_weights("p", both)
            end_ms = PERIOD_MS * (step + 1)
            brain.run_until(from_milliseconds(end_ms))
            found = brain.read_state("v", [2])[0] - REST
            assert found == pytest.approx(potential(weights, end_ms), abs=within_mv)
