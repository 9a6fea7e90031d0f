"""SpiNNaker as far as a board goes that is not there: networks are mapped, and no cell spikes."""

import pytest
from nrp_core.brain import FixedFrequencySource, SpikeRecorder
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError, CapabilityError

pytestmark = pytest.mark.simulator("spinnaker")
VIRTUAL = "[Machine]\nvirtual_board = True\nversion = 5\n"
DRIVE = {"rate": 200.0, "delay": 1.0}


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder for the configuration and the reports of sPyNNaker."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def build(sim):
    cells = sim.Population(300, sim.IF_cond_exp(tau_m=15.0), label="cells")
    source = sim.Population(3, sim.SpikeSourceArray(spike_times=[[5.0, 25.0], [6.0], []]), label="source")
    sim.Projection(source, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.01, delay=2.0))
    back = sim.StaticSynapse(weight=0.005, delay=20.0)
    sim.Projection(cells, cells, sim.FixedProbabilityConnector(0.1), back, receptor_type="inhibitory")


def opened_with(opened, network):
    return opened(network(build), "spinnaker", timestep="1 ms")


def test_a_network_is_mapped_and_stepped(home, network, opened):
    (home / ".spynnaker.cfg").write_text(VIRTUAL)
    brain = opened_with(opened, network)
    recorder = brain.add_sink(SpikeRecorder(), range(303), name="all")
    brain.add_source(FixedFrequencySource(weight=0.02, **DRIVE), range(300), name="device")
    for t_ms in (20, 40):
        brain.run_until(t_ms * NS_PER_MS)
    assert set(recorder.spikes().neurons.tolist()) == {300, 301}  # those of the core
    from spynnaker.pyNN.data import SpynnakerDataView

    # the cells take several cores, the sources some, and delays beyond 16 ms one more
    assert SpynnakerDataView.get_n_placements() > 6


def test_a_synapse_that_comes_late_is_refused(home, network, opened):
    (home / ".spynnaker.cfg").write_text(VIRTUAL)
    brain = opened_with(opened, network)
    brain.run_until(20 * NS_PER_MS)
    brain.add_source(FixedFrequencySource(weight=0.02, **DRIVE), [0], name="late")
    with pytest.raises(CapabilityError, match=r"'cells'.*weight 0"):
        brain.run_until(40 * NS_PER_MS)


def test_a_reset_maps_anew(home, network, opened):
    (home / ".spynnaker.cfg").write_text(VIRTUAL)
    brain = opened_with(opened, network)
    brain.run_until(20 * NS_PER_MS)
    brain.reset()
    brain.run_until(20 * NS_PER_MS)
    assert brain.now_ns == 20 * NS_PER_MS


def test_the_address_of_the_board_is_required(home, network, opened):
    with pytest.raises(BackendLoadError, match=r"machineName.*virtual_board = True"):
        opened_with(opened, network)
