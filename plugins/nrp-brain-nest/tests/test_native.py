"""A script of PyNEST that runs in NEST itself: the same spikes as there, devices, and what is refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_core import brains
from nrp_core.brain import Brain, DCSource, SpikeInjector, SpikeRecorder
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.experiment import network_from

from nrp_brain_nest.kernel import import_nest

SCRIPT = """
import nest
nest.ResetKernel()
nest.rng_seed = 7
ex = nest.Create("iaf_psc_alpha", 8)
inh = nest.Create("aeif_cond_alpha", 2)
both = ex + inh
noise = nest.Create("poisson_generator", params={"rate": 16000.0})
nest.Connect(noise, both, syn_spec={"weight": 30.0, "delay": 1.0})
nest.Connect(ex, both, {"rule": "fixed_indegree", "indegree": 3}, {"weight": 20.0, "delay": 1.0})
"""
RUN = "nest.Simulate(60.0)\n"
Opened = Callable[..., Brain]


@pytest.fixture
def script(tmp_path: Path) -> Callable[[str], Path]:
    """Write a script with ten cells."""

    def write(end: str) -> Path:
        path = tmp_path / "cells.py"
        path.write_text(SCRIPT + end)
        return path

    return write


def native(path: Path, **options: Any) -> Brain:
    backend = brains().load("nest")
    network = network_from(path, simulator="nest")
    return backend.open(network, seed=1, options=backend.options.model_validate(options))


def spikes_of(brain: Brain) -> set[tuple[int, float]]:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(10), name="spikes")
    for t_ms in range(5, 61, 5):
        brain.run_until(t_ms * NS_PER_MS)
    found = recorder.spikes()
    return set(zip(found.neurons.tolist(), found.times_ms.round(4).tolist(), strict=True))


def test_spikes_are_those_of_nest_alone_also_after_a_reset(script: Callable[[str], Path]) -> None:
    with native(script(RUN)) as brain:
        found = spikes_of(brain)
        brain.reset()
        assert spikes_of(brain) == found
    alone: dict[str, Any] = {}
    exec(SCRIPT + "recorder = nest.Create('spike_recorder')\nnest.Connect(both, recorder)\n" + RUN, alone)
    events = alone["recorder"].get("events")
    import_nest().ResetKernel()
    expected = zip((events["senders"] - 1).tolist(), events["times"].round(4).tolist(), strict=True)
    assert len(found) > 10
    assert found == set(expected)


def test_a_cell_that_sends_no_spikes_is_silent(script: Callable[[str], Path]) -> None:
    with native(script("rate = nest.Create('lin_rate_ipn', params={'mu': 3.0})\n" + RUN)) as brain:
        recorder = brain.add_sink(SpikeRecorder(), [8, 10], name="spikes")
        brain.run_until(60 * NS_PER_MS)
        assert set(recorder.spikes().neurons.tolist()) == {8}
        assert brain.read_state("rate", [10])[0] > 0


def test_node_collections_are_populations_or_views(script: Callable[[str], Path]) -> None:
    network = network_from(script(RUN), simulator="nest")
    assert {label: one.size for label, one in network.populations.items()} == {"ex": 8, "inh": 2}
    assert network.neurons("both").tolist() == list(range(10))
    assert network.populations["inh"].is_conductance_based


def test_devices_drive_cells_as_generators_of_nest_do(script: Callable[[str], Path]) -> None:
    quiet = "noise.rate = 0.0\n"
    with native(script(quiet + RUN)) as brain:
        brain.add_source(DCSource(amplitude=0.1), [1], name="current")
        spikes = brain.add_source(SpikeInjector(weight=0.1, delay=2.0), [2], name="spikes")
        assert hasattr(spikes, "inject_spikes")
        spikes.inject_spikes()
        brain.run_until(5 * NS_PER_MS)
        found = brain.read_state("v", [0, 1, 2])
    alone: dict[str, Any] = {}
    exec(SCRIPT + quiet, alone)
    nest, cells = alone["nest"], alone["ex"]
    cells[1].I_e = 100.0
    generator = nest.Create("spike_generator", params={"spike_times": [1.0]})
    nest.Connect(generator, cells[2], syn_spec={"weight": 100.0, "delay": 1.0})
    nest.Simulate(5.0)
    expected = cells[:3].get("V_m")
    nest.ResetKernel()
    assert found[1] > found[0] < found[2]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_script_or_option_that_does_not_fit_is_refused(script: Callable[[str], Path], golden: Any) -> None:
    with golden.raises(NetworkError, match="Simulate"):
        network_from(script(""), simulator="nest")
    with golden.raises(NetworkError, match="iaf_nothing"):
        network_from(script("nest.Create('iaf_nothing')\n" + RUN), simulator="nest")
    with golden.raises(CapabilityError, match="resolution"):
        native(script(RUN), resolution="1 ms")
