"""NEURON in several processes, of which the first talks with the loop, gives the spikes of one process."""

import numpy as np
import pytest
from nrp_core.brain import Brain, DCSource, Network, PoissonSource, SpikeRecorder, builder, network_of
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError, CapabilityError, SimulationError
from pydantic import ValidationError

from nrp_brain_pynn import PyNNBackend

pytestmark = pytest.mark.simulator("neuron")


def network(size: int = 21, delay_ms: float = 1.5) -> Network:
    sim = builder(3)
    sim.setup(timestep=0.1)
    cells = sim.Population(size, sim.IF_curr_alpha(tau_refrac=2.0), label="cells")
    noise = sim.Population(size, sim.SpikeSourcePoisson(rate=400.0), label="noise")
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.2), sim.StaticSynapse(weight=0.8, delay=1.0))
    back = sim.StaticSynapse(weight=-0.3, delay=delay_ms)
    sim.Projection(
        cells, cells, sim.FixedProbabilityConnector(0.2), back, receptor_type="inhibitory", label="back"
    )
    return network_of(sim.state, {})


def opened(processes: int, **changed: float) -> Brain:
    backend = PyNNBackend()
    return backend.open(network(**changed), seed=5, options=backend.options(processes=processes))


def course(brain: Brain) -> list[object]:
    """Run a brain with devices and changes; return its spikes, voltages and weights."""
    recorder = brain.add_sink(SpikeRecorder(), range(brain.network.size), name="all")
    devices = [
        brain.add_source(PoissonSource(rate=300.0, weight=0.5, delay=0.5), range(10), name="device"),
        brain.add_source(DCSource(amplitude=0.3), [3, 4], name="electrode"),
    ]
    for t_ms in range(20, 101, 20):
        brain.run_until(t_ms * NS_PER_MS)
    brain.set_parameters([0, 5], {"tau_refrac": 4.0})
    weights = brain.read_weights("back")
    brain.set_weights("back", 0.5 * weights)
    brain.run_until(160 * NS_PER_MS)
    spikes = recorder.spikes()
    v_mv = brain.read_state("v", np.arange(21))
    for device in (*devices, recorder):
        brain.remove(device)
    return [spikes.neurons.tolist(), spikes.times_ms.tolist(), v_mv.tolist(), weights.tolist()]


def test_two_processes_give_the_spikes_of_one_also_after_a_reset() -> None:
    with opened(1) as one, opened(2) as two:
        expected = course(one)
        assert len(expected[0]) > 500
        assert course(two) == expected
        two.reset()
        assert course(two) == expected


def test_an_error_of_the_processes_is_raised_here() -> None:
    with opened(2) as brain, pytest.raises(CapabilityError):
        brain.read_state("w", [0])
    with pytest.raises(CapabilityError, match="delay"):
        opened(2, delay_ms=0.1)


def test_the_end_of_a_process_ends_the_run() -> None:
    with opened(2) as brain:
        brain.run_until(NS_PER_MS)
        brain._process._process.kill()  # type: ignore[attr-defined]
        with pytest.raises(SimulationError):
            brain.run_until(1000 * NS_PER_MS)


def test_a_missing_mpirun_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(BackendLoadError, match="mpirun"):
        opened(3)


def test_only_neuron_has_several_processes() -> None:
    with pytest.raises(ValidationError, match="Brian2"):
        PyNNBackend.options(simulator="brian2", processes=2)
