"""Runs a network on NEURON in as many processes as ``mpirun`` started, and prints its spikes as JSON."""

import json
import sys

import numpy as np
from neuron import h

h.nrnmpi_init()  # before anything else starts to use NEURON
parallel = h.ParallelContext()

from nrp_core.brain import (  # noqa: E402
    DCSource,
    PoissonSource,
    SpikeRecorder,
    builder,
    network_of,
)
from nrp_core.clock import NS_PER_MS  # noqa: E402

from nrp_brain_pynn import PyNNBackend  # noqa: E402


def network(size=40):
    sim = builder(3)
    sim.setup(timestep=0.1)
    cells = sim.Population(size, sim.IF_curr_alpha(tau_refrac=2.0), label="cells")
    noise = sim.Population(size, sim.SpikeSourcePoisson(rate=400.0), label="noise")
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.2), sim.StaticSynapse(weight=0.4, delay=1.0))
    back = sim.StaticSynapse(weight=-0.3, delay=1.5)
    sim.Projection(cells, cells, sim.FixedProbabilityConnector(0.2), back, receptor_type="inhibitory")
    return network_of(sim.state, {})


def main():
    backend = PyNNBackend()
    options = backend.options(simulator="neuron")
    with backend.open(network(), seed=5, options=options) as brain:
        recorder = brain.add_sink(SpikeRecorder(), range(brain.network.size), name="all")
        brain.add_source(PoissonSource(rate=300.0, weight=0.5, delay=0.5), range(10), name="device")
        brain.add_source(DCSource(amplitude=0.3), [3, 4], name="electrode")
        for t_ms in range(20, 301, 20):
            brain.run_until(t_ms * NS_PER_MS)
        spikes = recorder.spikes()
        v_mv = brain.read_state("v", np.arange(40))
    if parallel.id() == 0:
        result = {
            "processes": int(parallel.nhost()),
            "spikes": sorted(zip(spikes.times_ms.tolist(), spikes.neurons.tolist(), strict=True)),
            "v_mv": v_mv.tolist(),
        }
        sys.stdout.write("\n" + json.dumps(result) + "\n")
        sys.stdout.flush()
    parallel.barrier()
    h.quit()


main()
