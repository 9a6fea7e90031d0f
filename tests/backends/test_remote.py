"""A brain in a process of its own is the brain it would be here."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_brain_event import EventBackend
from nrp_brain_spinnaker import SpinnakerBackend

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, PoissonSource
from nrp_core.brain.remote import RemoteBrain, RemoteOptions
from nrp_core.brain.remote.messages import SharedColumns
from nrp_core.brain.remote.process import Watchdog, end_idle
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError, CapabilityError, NetworkError, SimulationError
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.pynn import builder

if TYPE_CHECKING:  # the process of a brain imports this module as well
    from golden import Golden

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


def test_an_error_there_is_raised_here(remote, golden: Golden):
    with golden.raises(NetworkError, match=r"'cells' \(IF_curr_exp\).*'tau_mm'"):
        remote(EventBackend(), cells(tau_mm=3.0))


def test_a_request_that_cannot_be_met_has_no_side_effects(remote, golden: Golden):
    brain = remote(EventBackend(), cells())
    with golden.raises(CapabilityError, match="'cells'.*'gsyn_exc'"):
        brain.read_state("gsyn_exc", [0])
    brain.run_until(NS_PER_MS)


def test_a_process_that_dies_is_one_clear_error(remote, golden: Golden):
    brain = remote(EventBackend(), cells())
    brain.run_until(NS_PER_MS)
    os.kill(brain._process.pid, signal.SIGKILL)
    with golden.raises(SimulationError, match="SIGKILL"):
        brain.run_until(2 * NS_PER_MS)


LIMITED = "500 ms"
HANGS = r"the process of the brain \(.*\) hangs: for 0.5 s it has neither answered nor computed"


class LimitedOptions(type(EventBackend().options()), RemoteOptions):
    """Of the event backend in a process of its own."""


class LimitedBackend(EventBackend):
    """The event backend with a limit."""

    options = LimitedOptions


@pytest.mark.one_of(3)
@pytest.mark.parametrize("ask", [
    lambda brain: brain.run_until(2 * NS_PER_MS),
    lambda brain: brain.set_weights("p", np.ones(300_000)),  # more than a socket holds
], ids=["a step", "a long request"])  # fmt: skip
def test_a_process_that_hangs_is_one_clear_error(remote, ask, golden: Golden):
    index = np.zeros(300_000, np.int32)
    ones = np.ones(index.size)
    many = Projection("p", "cells", "cells", "excitatory", index, index + 1, ones, ones)
    brain = remote(LimitedBackend(), Network(cells().populations, (many,)), time_limit=LIMITED)
    brain.run_until(NS_PER_MS)
    os.kill(brain._process.pid, signal.SIGSTOP)
    with pytest.raises(SimulationError, match=HANGS):
        ask(brain)
    with pytest.raises(ProcessLookupError):
        os.kill(brain._process.pid, 0)
    with golden.raises(SimulationError, match="SIGKILL"):
        brain.reset()


def test_a_limit_may_be_a_little_less_than_whole_seconds(remote):
    brain = remote(LimitedBackend(), cells(), time_limit="3999999999 ns")
    brain.run_until(NS_PER_MS)
    assert brain.now_ns == NS_PER_MS


def test_a_process_that_hangs_while_it_opens_is_one_clear_error(tmp_path):
    lazy = tmp_path / "python"
    lazy.write_text("#!/bin/sh\nexec sleep 100\n")
    lazy.chmod(0o755)
    backend = LimitedBackend()
    with pytest.raises(BackendLoadError, match=HANGS):
        RemoteBrain(backend, cells(), seed=1, options=backend.options(time_limit=LIMITED), python=str(lazy))


def test_a_process_that_works_longer_than_the_limit_is_waited_for():
    script = "import os; end = 0.6\nwhile os.times().user < end: pass"
    process = subprocess.Popen(["sh", "-c", f"{sys.executable} -c '{script}'; true"])  # a child does the work
    watch, looks = Watchdog(process.pid, 0.2, AssertionError), 0
    while process.poll() is None:
        time.sleep(watch.between_checks_s)
        if process.poll() is None:
            watch.check()
            looks += 1
    assert looks > 4


def test_many_spikes_pass_in_one_step(remote):
    size, count = 50, 40_000
    noise = {"rate": np.full(size, 1e6), "start": np.zeros(size), "duration": np.full(size, np.inf)}
    network = Network({"noise": Population("noise", size, "SpikeSourcePoisson", noise)})
    backend, found = SpinnakerBackend(), []
    for brain in (backend.open(network, seed=5, options=backend.options()), remote(backend, network)):
        recorder = brain.add_sink(SpikeRecorder(), range(size), name="recorder")
        brain.run_until(NS_PER_MS)
        brain.run_until(2 * NS_PER_MS)
        found.append((recorder.spikes().neurons.tolist(), recorder.spikes().times_ms.tolist()))
        brain.close()
    assert len(found[0][0]) > count
    assert found[0] == found[1]


@given(st.lists(st.lists(st.lists(st.floats(allow_nan=False), max_size=9000), max_size=4), max_size=4))
def test_shared_columns_are_read_as_they_were_written(messages):
    here = SharedColumns()
    there = SharedColumns(os.dup(here.descriptor))
    try:
        for turn, message in enumerate(messages):
            writer, reader = (here, there) if turn % 2 else (there, here)
            columns = [np.array(column, float) for column in message]
            total = writer.write([np.arange(3), *columns])
            block = reader.read(total)
            assert block[:3].tolist() == [0, 1, 2]
            assert block[3:].view(np.float64).tolist() == [x for column in message for x in column]
    finally:
        here.close()
        there.close()


def test_a_program_that_is_not_python_with_nrp_core_does_not_open(remote, golden: Golden):
    with golden.raises(BackendLoadError):
        remote(EventBackend(), cells(), python="false")
    with golden.raises(BackendLoadError, match="'no-such-python'"):
        remote(EventBackend(), cells(), python="no-such-python")


@pytest.fixture
def python(tmp_path):
    """Return what makes a Python that finds files of its own first."""

    def make(files, *flags):
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True)
            path.write_text(text)
        program = tmp_path / "python"
        program.write_text(f'#!/bin/sh\nPYTHONPATH={tmp_path} exec {sys.executable} {" ".join(flags)} "$@"\n')
        program.chmod(0o755)
        return str(program)

    return make


LACKS = {
    "nrp-core": ({}, ["-S"], "PackageNotFoundError: No package metadata was found for nrp-core"),
    "the version": (
        {"nrp_core-0.0.1.dist-info/METADATA": "Name: nrp-core\nVersion: 0.0.1\n"}, [],
        "ImportError: it has nrp-core 0.0.1",
    ),
    "a library": (
        {"nrp_brain_event/__init__.py": "raise OSError('libevent.so:\\nno such file')"}, [],
        "OSError: libevent.so: no such file",
    ),
    "a part of nrp-core": (
        {"nrp_core/__init__.py": ""}, [], "ModuleNotFoundError: No module named 'nrp_core.brain'",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("files", "flags", "reason"), LACKS.values(), ids=LACKS)
def test_a_package_that_another_python_lacks_is_one_clear_error(files, flags, reason, python, remote, capfd):
    with pytest.raises(BackendLoadError) as caught:
        remote(EventBackend(), cells(), python=python(files, *flags))
    assert f"/python) does not start: {reason}; " in str(caught.value)
    assert f"needs nrp-core {version('nrp-core')}, as here, and the backend" in str(caught.value)
    assert capfd.readouterr().err == ""


class NeedyBackend(EventBackend):
    """A backend whose simulator does not load."""

    def open(self, network, *, seed, options):
        import no_such_simulator  # noqa: F401


def test_a_simulator_that_does_not_load_there_is_one_clear_error(remote, capfd, golden: Golden):
    reason = "does not open a brain: ModuleNotFoundError: No module named 'no_such_simulator'"
    with golden.raises(BackendLoadError, match=f"{reason}"):
        remote(NeedyBackend(), cells())
    assert capfd.readouterr().err == ""


def test_a_python_in_the_home_folder_is_found(python, remote, tmp_path, monkeypatch):
    python({})
    monkeypatch.setenv("HOME", str(tmp_path))
    brain = remote(EventBackend(), cells(), python="~/python")
    brain.run_until(NS_PER_MS)
    assert brain.now_ns == NS_PER_MS


def runs(pid):
    """Return whether a process has not ended."""
    with suppress(ProcessLookupError):
        os.kill(pid, 0)
        return True
    return False


def test_the_process_of_a_closed_brain_serves_the_next_one_as_a_new_one_would(remote):
    expected = run(first := remote(EventBackend(), cells()), driven(first), 200)
    first.set_parameters([3], {"i_offset": 9.0})
    first.close()
    second = remote(EventBackend(), cells())
    assert second._process.pid == first._process.pid
    assert run(second, driven(second), 200) == expected


@pytest.mark.heavy
def test_a_process_is_not_used_where_a_new_one_would_differ(remote, tmp_path, monkeypatch):
    first = remote(LimitedBackend(), cells(), time_limit="10 s")
    first.close()
    slower = remote(LimitedBackend(), cells(), time_limit="20 s")
    other = remote(SpinnakerBackend(), cells())
    monkeypatch.chdir(tmp_path)
    elsewhere = remote(LimitedBackend(), cells(), time_limit="10 s")
    assert first._process.pid not in {brain._process.pid for brain in (slower, other, elsewhere)}


def test_a_process_whose_brain_has_failed_ends_with_it(remote):
    brain = remote(EventBackend(), cells())
    with pytest.raises(NetworkError):
        brain._process.call("read_weights", "nothing")
    brain.close()
    assert not runs(brain._process.pid)


def test_an_idle_process_that_has_ended_is_replaced(remote):
    first = remote(EventBackend(), cells())
    first.close()
    os.kill(first._process.pid, signal.SIGKILL)
    os.waitid(os.P_PID, first._process.pid, os.WEXITED | os.WNOWAIT)
    second = remote(EventBackend(), cells())
    second.run_until(NS_PER_MS)
    assert second.now_ns == NS_PER_MS


def test_two_idle_processes_are_kept_at_most_and_none_at_the_end(remote):
    brains = [remote(EventBackend(), cells()) for _ in range(3)]
    for brain in brains:
        brain.close()
    assert [runs(brain._process.pid) for brain in brains] == [False, True, True]
    end_idle()
    assert not any(runs(brain._process.pid) for brain in brains)


def test_changes_of_parameters_and_weights_reach_the_other_process(remote, golden: Golden):
    index = np.zeros(1, np.int32)
    synapse = Projection("p", "cells", "cells", "excitatory", index, index + 1, np.ones(1), np.ones(1))
    brain = remote(EventBackend(), Network(cells().populations, (synapse,)))
    recorder = driven(brain)
    brain.set_parameters([3], {"i_offset": 2.0})
    brain.set_weights("p", 0.25)
    run(brain, recorder, 100)
    assert set(recorder.spikes().neurons) >= {2, 3}
    assert brain.read_weights("p") == [0.25]
    with golden.raises(NetworkError):
        brain.set_parameters([1], {"tau_refrac": 0.0, "v_reset": -40.0})
    brain.run_until(120 * NS_PER_MS)


def plastic():
    sim = builder()
    pre = sim.Population(1, sim.SpikeSourceArray(spike_times=[10.0, 50.0, 90.0]), label="pre")
    forced = sim.Population(1, sim.SpikeSourceArray(spike_times=[14.0, 54.0, 94.0]), label="forced")
    cell = sim.Population(1, sim.IF_curr_exp(tau_m=5.0), label="cell")
    sim.Projection(forced, cell, sim.AllToAllConnector(), sim.StaticSynapse(weight=100.0, delay=1.0))
    timing, limits = sim.SpikePairRule(A_plus=0.01, A_minus=0.0), sim.AdditiveWeightDependence(w_max=2.0)
    rule = sim.STDPMechanism(timing, limits, weight=0.1, delay=1.0)
    sim.Projection(pre, cell, sim.AllToAllConnector(), rule, label="p")
    return sim.network()


def test_learning_stops_in_the_other_process(remote):
    brain = remote(EventBackend(), plastic())
    weights = []
    for until_ms, learns in ((40, False), (80, True), (120, True)):
        brain.run_until(until_ms * NS_PER_MS)
        brain.set_plastic("p", learns)
        weights.append(brain.read_weights("p")[0])
    assert 0.1 < weights[0] == weights[1] < weights[2]


def test_a_brain_that_cannot_stop_learning_refuses_it(remote, golden: Golden):
    with golden.raises(CapabilityError):
        remote(SpinnakerBackend(), plastic()).set_plastic("p", False)


def test_rewards_reach_the_other_process(remote):
    sim = builder()
    pre = sim.Population(1, sim.SpikeSourceArray(spike_times=[10.0]), label="pre")
    forced = sim.Population(1, sim.SpikeSourceArray(spike_times=[14.0]), label="forced")
    cell = sim.Population(1, sim.IF_curr_exp(tau_m=5.0), label="cell")
    each = sim.AllToAllConnector()
    sim.Projection(forced, cell, each, sim.StaticSynapse(weight=100.0, delay=1.0))
    rule = sim.STDPMechanism(sim.SpikePairRule(), sim.AdditiveWeightDependence(), weight=0.1, delay=1.0)
    sim.Projection(pre, cell, each, rule, label="p")
    sim.Projection(pre, cell, each, sim.Neuromodulation(), receptor_type="reward", label="reward")
    brain = remote(EventBackend(), sim.network())
    brain.run_until(40 * NS_PER_MS)
    brain.reward("p", 0.5)
    assert brain.read_synapse_state("p", "dopamine").tolist() == [0.5]
    brain.run_until(80 * NS_PER_MS)
    assert brain.read_weights("p")[0] > 0.1
