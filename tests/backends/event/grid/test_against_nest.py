"""Dense networks fire exactly as in NEST.

``cuba_nest.npz`` and ``coba_nest.npz`` hold the spikes of 300 ms from NEST 3.10.0 (iaf_psc_exp,
iaf_cond_exp, one thread, 0.1 ms), made by benchmarks/peers/nest_run.py from the graphs of
benchmarks/peers/graphs.py.
"""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from nrp_brain_event import EventBackend, EventOptions

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.clock import NS_PER_MS

PEERS = Path(__file__).parents[4] / "benchmarks" / "peers"


@pytest.mark.heavy
@pytest.mark.parametrize("model", ["cuba", "coba"])
def test_all_spikes_are_those_of_nest(model: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(PEERS), *sys.path])
    graphs, runner = importlib.import_module("graphs"), importlib.import_module("nrp_run")
    network = runner.network_of(graphs.make(model, 4000))
    with EventBackend().open(network, seed=1, options=EventOptions(resolution="0.1 ms")) as brain:
        recorder = brain.add_sink(SpikeRecorder(), np.arange(4000), name="all")
        brain.run_until(300 * NS_PER_MS)
        spikes = recorder.spikes()
    with np.load(Path(__file__).parent / f"{model}_nest.npz") as expected:
        assert len(expected["steps"]) > 5000
        np.testing.assert_array_equal(np.rint(spikes.times_ms * 10), expected["steps"])
        np.testing.assert_array_equal(spikes.neurons, expected["neurons"])
