"""A brain in a process of its own is the brain it would be here."""

import os
import signal
import sys

import numpy as np
import pytest
from nrp_brain_event import EventBackend
from nrp_brain_spinnaker import SpinnakerBackend

from nrp_core.brain.network import Network, Population, Projection
from nrp_core.brain.remote import RemoteBrain
from nrp_core.brain.sinks import SpikeRecorder
from nrp_core.brain.sources import DCSource, PoissonSource
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError, CapabilityError, NetworkError, SimulationError

BACKENDS = [EventBackend(), SpinnakerBackend()]
PARAMETERS = {
    "v_rest": -65.0, "cm": 1.0, "tau_m": 20.0, "tau_refrac": 2.0, "v_reset": -65.0, "v_thresh": -50.0,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0, "i_offset": 0.0,
}  # fmt: skip


def cells(**given):
    values = {name: np.full(4, value) for name, value in (PARAMETERS | given).items()}
    noise = {"rate": np.full(2, 100.0), "start": np.zeros(2), "duration": np.full(2, np.inf)}
    populations = (
        Population("cells", 4, "IF_curr_exp", values),
        Population("noise", 2, "SpikeSourcePoisson", noise),
    )
    return Network({population.label: population for population in populations})


@pytest.fixture
def remote():
    brains = []

    def open_(backend, network, seed=5, python=sys.executable, **options):
        given = backend.options(**options)
        brains.append(RemoteBrain(backend, network, seed=seed, options=given, python=python))
        return brains[-1]

    yield open_
    for brain in brains:
        brain.close()


def driven(brain):
    """Put devices of each kind to work and return a recorder of all spikes."""
    brain.add_source(PoissonSource(rate=800.0, weight=2.0, delay=1.0), [0, 1], name="noise")
    brain.add_source(DCSource(amplitude=1.0), [2], name="electrode")
    return brain.add_sink(SpikeRecorder(), range(brain.network.size), name="recorder")


def run(brain, recorder, until_ms):
    for t_ms in range(round(brain.now_ns / NS_PER_MS) + 20, until_ms + 1, 20):
        brain.run_until(t_ms * NS_PER_MS)
    spikes = recorder.spikes()
    return spikes.neurons.tolist(), spikes.times_ms.tolist(), brain.read_state("v", [3, 0, 2]).tolist()


@pytest.mark.parametrize("backend", BACKENDS, ids=lambda b: type(b).__name__)
def test_a_remote_brain_does_what_a_brain_here_does(backend, remote):
    network, options = cells(), backend.options()
    results = []
    for brain in (backend.open(network, seed=5, options=options), remote(backend, network)):
        results.append(run(brain, driven(brain), 200))
        brain.close()
    assert len(results[0][0]) > 20
    assert results[0] == results[1]


def test_a_snapshot_and_a_reset_reach_the_other_process(remote):
    brain = remote(EventBackend(), cells())
    recorder = driven(brain)
    run(brain, recorder, 100)
    snapshot = brain.snapshot()
    first = run(brain, recorder, 200)
    brain.restore(snapshot)
    assert run(brain, recorder, 200) == first
    brain.reset()
    assert run(brain, recorder, 200) == first


def test_a_population_that_the_simulator_draws_itself_is_not_drawn_twice(remote):
    backend, network = SpinnakerBackend(), cells()
    here = backend.open(network, seed=5, options=backend.options(poisson="machine"))
    there = remote(backend, network, poisson="machine")
    results = [run(brain, driven(brain), 200) for brain in (here, there)]
    assert results[0] == results[1]


def test_two_brains_have_two_processes(remote):
    first, second = remote(EventBackend(), cells()), remote(EventBackend(), cells(i_offset=1.0))
    first.run_until(50 * NS_PER_MS)
    second.run_until(20 * NS_PER_MS)
    assert first.read_state("v", [0])[0] == -65.0
    assert second.read_state("v", [0])[0] > -60.0


def test_an_error_there_is_raised_here(remote):
    with pytest.raises(
        NetworkError, match=r"'cells' \(IF_curr_exp\) has no parameter 'tau_mm'; did you mean"
    ):
        remote(EventBackend(), cells(tau_mm=3.0))


def test_a_request_that_cannot_be_met_breaks_nothing(remote):
    brain = remote(EventBackend(), cells())
    with pytest.raises(CapabilityError, match="'cells' have no 'gsyn_exc'"):
        brain.read_state("gsyn_exc", [0])
    brain.run_until(NS_PER_MS)


def test_a_process_that_dies_is_one_clear_error(remote):
    brain = remote(EventBackend(), cells())
    brain.run_until(NS_PER_MS)
    os.kill(brain._process.pid, signal.SIGKILL)
    with pytest.raises(SimulationError, match=r"the process of the brain \(.*\) was ended by SIGKILL"):
        brain.run_until(2 * NS_PER_MS)


def test_a_program_that_is_no_python_with_nrp_core_does_not_open(remote):
    with pytest.raises(
        BackendLoadError, match="ended with exit code 1 before it was ready; that Python needs"
    ):
        remote(EventBackend(), cells(), python="false")
    with pytest.raises(BackendLoadError, match="'no-such-python' is not a program that can be run"):
        remote(EventBackend(), cells(), python="no-such-python")


def test_closing_a_brain_ends_its_process(remote):
    brain = remote(EventBackend(), cells())
    pid = brain._process.pid
    brain.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_changes_of_parameters_and_weights_reach_the_other_process(remote):
    index = np.zeros(1, np.int32)
    synapse = Projection("p", "cells", "cells", "excitatory", index, index + 1, np.ones(1), np.ones(1))
    brain = remote(EventBackend(), Network(cells().populations, (synapse,)))
    recorder = driven(brain)
    brain.set_parameters([3], {"i_offset": 2.0})
    brain.set_weights("p", 0.25)
    run(brain, recorder, 100)
    assert set(recorder.spikes().neurons) >= {2, 3}
    assert brain.read_weights("p") == [0.25]
    with pytest.raises(NetworkError, match=r"cell 1 has no refractory time"):
        brain.set_parameters([1], {"tau_refrac": 0.0, "v_reset": -40.0})
    brain.run_until(120 * NS_PER_MS)
