"""One brain in NEST: its life, its threads, what it refuses."""

import subprocess
import sys

import numpy as np
import pytest
from golden import Golden
from nrp_core.brain import PoissonSource, RemoteBrain, SpikeRecorder
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, LifecycleError, NetworkError, TimestepError
from pydantic import ValidationError

from nrp_brain_nest import NestBackend, NestOptions
from nrp_brain_nest.brain import NestBrain


def busy(sim):
    """Build a network in which every kind of input and synapse takes part."""
    cells = sim.Population(20, sim.IF_cond_exp(), label="cells")
    noise = sim.Population(20, sim.SpikeSourcePoisson(rate=300.0), label="noise")
    static = sim.StaticSynapse(weight=0.02, delay=1.5)
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.3), static)
    tired = sim.TsodyksMarkramSynapse(weight=0.03, delay=1.0, U=0.5, tau_rec=100.0, tau_facil=0.0)
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.3), tired)
    plain = sim.StaticSynapse(weight=0.01, delay=0.5)
    sim.Projection(cells, cells, sim.FixedProbabilityConnector(0.3), plain, receptor_type="inhibitory")


def spikes_of(brain, ms=200):
    recorder = brain.add_sink(SpikeRecorder(), range(brain.network.size), name="recorder")
    brain.add_source(PoissonSource(rate=500.0, weight=0.02, delay=0.3), range(5), name="device")
    brain.run_until(ms * NS_PER_MS)
    spikes = recorder.spikes()
    assert len(spikes) > 1000
    return spikes.neurons.tolist(), spikes.times_ms.tolist()


def test_a_reset_brain_equals_a_fresh_one(network, opened):
    made = network(busy)
    brain = opened(made)
    first = spikes_of(brain)
    brain.run_until(231 * NS_PER_MS)
    for device in brain.devices:
        brain.remove(device)
    brain.reset()
    assert brain.now_ns == 0
    assert spikes_of(brain) == first


def test_threads_do_not_change_the_spikes(network, opened):
    made, trains = network(busy), []
    for threads in (1, 2):
        brain = opened(made, threads=threads)
        trains.append(spikes_of(brain))
        brain.close()
    assert trains[0] == trains[1]


def test_a_second_brain_gets_a_process_of_its_own(network, opened):
    made = network(busy)
    first, second = opened(made), opened(made)
    assert isinstance(first, NestBrain)
    assert isinstance(second, RemoteBrain)
    first.run_until(50 * NS_PER_MS)
    trains = [spikes_of(second)]
    first.close()
    third = opened(made)
    assert isinstance(third, NestBrain)
    assert [spikes_of(third)] == trains


def test_a_brain_that_does_not_open_leaves_the_kernel_free(network, opened, golden: Golden):
    early = {"v_thresh": -40.0, "v_spike": -45.0}
    bad = network(lambda sim: sim.Population(1, sim.EIF_cond_exp_isfa_ista(**early), label="bad"))
    with golden.raises(NetworkError, match="'bad'"):
        opened(bad)
    assert opened(network(busy)).now_ns == 0


def test_a_closed_brain_is_closed(network, opened, golden: Golden):
    brain = opened(network(busy))
    brain.close()
    with golden.raises(LifecycleError):
        brain.run_until(NS_PER_MS)


def test_a_time_off_the_grid_is_refused_and_harms_nothing(network, opened):
    brain = opened(network(busy))
    with pytest.raises(TimestepError, match=r"0.1.*1.05"):
        brain.run_until(1_050_000)
    brain.run_until(NS_PER_MS)


def test_snapshots_are_not_supported(network, opened, golden: Golden):
    with golden.raises(CapabilityError):
        opened(network(busy)).snapshot()


def test_a_variable_that_cells_lack_is_refused_by_population(network, opened):
    brain = opened(network(lambda sim: sim.Population(1, sim.IF_curr_exp(), label="cells")))
    with pytest.raises(CapabilityError, match=r"'cells'.*'gsyn_exc'"):
        brain.read_state("gsyn_exc", [0])


def test_source_cells_have_no_state(network, opened):
    brain = opened(network(busy))
    with pytest.raises(CapabilityError, match=r"'v'.*spikes"):
        brain.read_state("v", [0, 39])


def test_a_parameter_that_nest_refuses_at_the_start_is_refused(network, opened):
    def build(sim):
        cells = sim.Population(1, sim.IF_curr_exp(), label="cells")
        cells.initialize(isyn_exc=0.5)

    with pytest.raises(CapabilityError, match=r"'cells'.*isyn_exc = 0.5"):
        opened(network(build))


def test_delays_that_the_grid_changes_are_reported(network, opened):
    def build(sim):
        cells = sim.Population(2, sim.IF_curr_exp(), label="cells")
        static = sim.StaticSynapse(weight=1.0, delay=0.3)
        sim.Projection(cells[0:1], cells[1:2], sim.AllToAllConnector(), static, label="odd")

    made = network(build)
    exact = opened(made)
    assert exact.warnings == []
    exact.close()
    coarse = opened(made, resolution="1 ms")
    assert coarse.warnings.messages == ["projection 'odd': delays are whole numbers of 1 ms in NEST"]


def test_a_network_of_sources_alone_runs(network, opened):
    brain = opened(network(lambda sim: sim.Population(3, sim.SpikeSourceArray(spike_times=[1.0, 2.0]))))
    recorder = brain.add_sink(SpikeRecorder(), [0, 1, 2], name="recorder")
    brain.run_until(5 * NS_PER_MS)
    assert np.bincount(recorder.spikes().neurons).tolist() == [2, 2, 2]


@pytest.mark.parametrize("resolution", ["0.5 us", "2 ms"])
def test_a_grid_that_nest_does_not_have_is_refused(resolution, golden: Golden):
    with golden.raises(ValidationError):
        NestOptions(resolution=resolution)


def test_capabilities_are_reported_without_loading_nest():
    code = (
        "import sys; from nrp_brain_nest import NestBackend, NestOptions; backend = NestBackend(); "
        "backend.capabilities(NestOptions()); backend.diagnose(); assert 'nest' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_doctor_finds_nest():
    (diagnosis,) = NestBackend().diagnose()
    assert diagnosis.present
    assert diagnosis.needed
