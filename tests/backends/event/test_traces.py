"""State that is recorded inside compiled code is the state that can be read at the same times."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from nrp_brain_event.backend import EventBackend

from nrp_core.brain import DCSource, StateRecorder, builder

OPTIONS = {
    "exact": {},
    "grid": {"resolution": "0.1 ms"},
    "two threads": {"resolution": "0.1 ms", "threads": 2},
}


def network() -> Any:
    """Return cells of all kinds, some refractory at any time, driven by noise."""
    sim = builder(seed=3)
    sim.setup(timestep=0.1)
    noise = sim.Population(20, sim.SpikeSourcePoisson(rate=200.0), label="noise")
    for cell, weight in (
        (sim.IF_curr_exp(i_offset=0.9, tau_refrac=3.0, v_reset=-70.0), 0.5),
        (sim.IF_cond_alpha(tau_refrac=2.0), 0.02),
        (sim.IF_curr_delta(tau_refrac=1.0), 4.0),
        (sim.EIF_cond_exp_isfa_ista(i_offset=0.5), 0.01),
    ):
        cells = sim.Population(5, cell, label=type(cell).__name__)
        synapse = sim.StaticSynapse(weight=weight, delay=1.5)
        sim.Projection(noise, cells, sim.FixedNumberPreConnector(10), synapse)
    return sim.network()


WATCHED = (
    ("v", range(20, 40), 0.5),
    ("gsyn_exc", [37, 26, 35], 0.3),
    ("w", [36, 35], 0.25),
    ("v", [38, 21], 7.0),
    ("v", range(20, 35), 0.4),
    ("v", range(25, 30), 0.5),
)


@pytest.mark.parametrize("given", OPTIONS.values(), ids=OPTIONS)
def test_samples_are_the_states_that_can_be_read_then(given: dict[str, Any]) -> None:
    backend, built = EventBackend(), network()
    options = backend.options.model_validate(given)
    with (
        backend.open(built, seed=1, options=options) as watched,
        backend.open(built, seed=1, options=options) as read,
    ):
        for brain in (watched, read):
            brain.add_source(DCSource(amplitude=0.2), [21, 27], name="current")
        ports: list[Any] = [
            watched.add_sink(StateRecorder(variable, dt), list(ids), name=f"{variable}{dt}")
            for variable, ids, dt in WATCHED
        ]
        for until_ms in (13, 50, 61):
            watched.run_until(until_ms * 1_000_000)
        samples = [port.samples() for port in ports]
        assert [len(times) for times, _ in samples] == [123, 204, 245, 9, 153, 123]
        for time in np.unique(np.concatenate([times for times, _ in samples])):
            read.run_until(round(time * 1e6))
            for (variable, ids, _), (times, values) in zip(WATCHED, samples, strict=True):
                for row in values[times == time]:
                    assert row.tolist() == read.read_state(variable, list(ids)).tolist()
        assert np.ptp(samples[0][1], axis=0).min() > 1.0, "every cell was driven"


def test_a_kept_time_bounds_what_is_stored() -> None:
    backend, built = EventBackend(), network()
    options = backend.options.model_validate({"resolution": "0.1 ms"})
    with backend.open(built, seed=1, options=options) as brain:
        port: Any = brain.add_sink(StateRecorder("v", 0.5, keep_ms=5.0), [20], name="v")
        for until_ms in (20, 40, 43):
            brain.run_until(until_ms * 1_000_000)
        times, values = port.samples()
        assert times.tolist() == [38.5 + 0.5 * k for k in range(10)]
        assert values.shape == (10, 1)
