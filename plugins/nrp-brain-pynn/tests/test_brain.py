"""One brain in one of PyNN's simulators: its life, its processes, what it refuses."""

import gc
import os
import signal
import sys
import tracemalloc
from importlib import import_module

import numpy as np
import pytest
from nrp_core.brain import PoissonSource, RemoteBrain, SpikeRecorder
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, SimulationError, TimestepError

from nrp_brain_pynn.brain import PyNNBrain


def busy(sim):
    cells = sim.Population(10, sim.IF_cond_exp(), label="cells")
    noise = sim.Population(10, sim.SpikeSourcePoisson(rate=300.0), label="noise")
    static = sim.StaticSynapse(weight=0.02, delay=1.5)
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.3), static)
    tired = sim.TsodyksMarkramSynapse(weight=0.03, delay=1.0, U=0.5, tau_rec=100.0, tau_facil=0.0)
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.3), tired)
    plain = sim.StaticSynapse(weight=0.01, delay=0.5)
    sim.Projection(cells, cells, sim.FixedProbabilityConnector(0.3), plain, receptor_type="inhibitory")


def spikes_of(brain, ms=100):
    recorder = brain.add_sink(SpikeRecorder(), range(brain.network.size), name="recorder")
    brain.add_source(PoissonSource(rate=500.0, weight=0.02, delay=0.3), range(5), name="device")
    while brain.now_ns < ms * NS_PER_MS:
        brain.run_until(brain.now_ns + 20 * NS_PER_MS)
    spikes = recorder.spikes()
    return spikes.neurons.tolist(), spikes.times_ms.tolist()


def test_a_reset_brain_is_a_fresh_one(simulator, network, opened):
    brain = opened(network(busy), simulator)
    first = spikes_of(brain)
    assert len(first[0]) > 300
    for device in brain.devices:
        brain.remove(device)
    brain.reset()
    assert spikes_of(brain) == first


def test_a_second_brain_gets_a_process_of_its_own_and_does_the_same(simulator, network, opened):
    made = network(busy)
    first, second = opened(made, simulator), opened(made, simulator)
    assert isinstance(first, PyNNBrain)
    assert isinstance(second, RemoteBrain)
    assert spikes_of(first) == spikes_of(second)


def test_the_death_of_its_process_is_one_clear_error(simulator, network, opened):
    brain = opened(network(busy), simulator, python=sys.executable)
    brain.run_until(20 * NS_PER_MS)
    os.kill(brain._process.pid, signal.SIGKILL)
    with pytest.raises(SimulationError, match="SIGKILL"):
        brain.run_until(40 * NS_PER_MS)


def held_memory(simulator):
    """Return the bytes of Python and NumPy, and how many numbers are in vectors of NEURON."""
    gc.collect()
    in_vectors = 0
    if simulator == "neuron":
        vectors = import_module("neuron").h.List("Vector")
        in_vectors = sum(int(vectors.o(i).size()) for i in range(int(vectors.count())))
    return tracemalloc.get_traced_memory()[0], in_vectors


def test_a_step_leaves_nothing_behind(simulator, network, opened):
    brain = opened(network(busy), simulator)
    brain.add_source(PoissonSource(rate=500.0, weight=0.02, delay=0.3), range(5), name="device")
    held, steps = [], 20
    tracemalloc.start()
    try:
        for _ in range(3):  # after the first, caches are filled
            for _ in range(steps):
                brain.run_until(brain.now_ns + 5 * NS_PER_MS)
            held.append(held_memory(simulator))
    finally:
        tracemalloc.stop()
    (bytes_before, vectors_before), (bytes_after, vectors_after) = held[1:]
    assert vectors_after == vectors_before
    assert bytes_after - bytes_before < 400 * steps  # some, as of numbers that have become larger


def test_several_synapses_between_two_cells_keep_their_own_weights(simulator, network, opened):
    def pair(weights):
        def build(sim):
            cells = sim.Population(1, sim.IF_curr_exp(tau_m=1e3), label="cells")
            source = sim.Population(1, sim.SpikeSourceArray(spike_times=[3.0]), label="source")
            rows = [(0, 0, weight, 1.0) for weight in weights]
            sim.Projection(source, cells, sim.FromListConnector(rows), sim.StaticSynapse())

        return network(build)

    heights = []
    for weights in ([0.1, 0.3], [0.4]):
        brain = opened(pair(weights), simulator)
        brain.run_until(15 * NS_PER_MS)
        heights.append(brain.read_state("v", [0])[0])
        brain.close()
    assert heights[0] > -64.5
    assert heights[0] == pytest.approx(heights[1], abs=1e-9)


def test_a_time_between_two_steps_is_refused_and_harms_nothing(simulator, network, opened):
    brain = opened(network(busy), simulator)
    with pytest.raises(TimestepError, match=r"0.1.*1.05"):
        brain.run_until(1_050_000)
    brain.run_until(NS_PER_MS)


def test_a_variable_that_cells_lack_is_refused_by_population(simulator, network, opened):
    brain = opened(network(busy), simulator)
    with pytest.raises(CapabilityError, match="'cells'"):
        brain.read_state("w", [0])
    assert np.isfinite(brain.read_state("v", [0, 3])).all()
