"""Transfer functions reach what the brain file has built, by PyNN's methods and by calls of NEST."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from math import log
from pathlib import Path

import numpy as np
import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

Played = Callable[..., Run]
Written = Callable[..., Path]

IN_PYNN = """
from hbp_nrp_cle.brainsim import simulator as sim
sim.setup(timestep=0.1)
class Net(object):
    def __init__(self):
        self.left = sim.Population(3, sim.IF_cond_alpha(tau_refrac=2.0), label='left')
        self.both = {'a': self.left, 'b': sim.Population(2, sim.IF_cond_alpha(), label='b')}
    def rests(self):
        return self.left.get('tau_refrac')
net = Net()
circuit = sim.Population(6, sim.IF_cond_alpha(), label='c')
pops = [circuit[0:2], circuit[2:4], circuit[4:6]]
source = sim.Population(1, sim.SpikeSourceArray(spike_times=[5.0]), label='source')
proj = sim.Projection(source, circuit, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.001, delay=1.0))
stop = sim.Projection(net.left, circuit, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.01, delay=1.0),
                      receptor_type='inhibitory')
circuit.record('spikes')
N = 3
def weights(): return proj.get('weight', format='array')
def let_weights(w): proj.set(weight=w)
def cells_of(i): return pops[i]
"""
OF_PYNN = """
import nest
@nrp.MapSpikeSource("a", nrp.brain.pops[1], nrp.dc_source, amplitude=3.0)
@nrp.MapSpikeSource("b", nrp.brain.net.both['b'][0], nrp.dc_source, amplitude=3.0)
@nrp.MapSpikeSource("groups", nrp.map_neurons(range(nrp.config.brain_root.N), lambda i: nrp.brain.pops[i]),
                    nrp.dc_source)
@nrp.MapSpikeSink("s", nrp.config.brain_root.cells_of(1), nrp.spike_recorder)
@nrp.MapSpikeSink("r", nrp.resolve(lambda brain: brain.pops[1][0]), nrp.spike_recorder)
@nrp.Robot2Neuron()
def function(t, a, b, groups, s, r):
    root = nrp.config.brain_root
    if abs(t - 0.1) > 1e-6:
        return
    assert root.weights()[0, 0] == 0.001 and len(groups) == root.N
    spikes = root.circuit.getSpikes()
    assert len(spikes) > 5 and set(spikes[:, 0]) == {2., 3.}
    trains = root.circuit.get_data().segments[0].spiketrains
    counts = root.circuit.get_spike_counts()
    assert [len(train) for train in trains] == [counts[i] for i in root.circuit.ids.tolist()]
    assert root.circuit.mean_spike_count() == len(spikes) / 6.
    root.let_weights(0.05)
    root.source.set(spike_times=[130.0, 145.0])
    root.net.left.set(tau_refrac=7.0)
    root.net.left[0].tau_refrac = 9.0
    assert root.net.rests().tolist() == [9.0, 7.0, 7.0] and root.net.left[1].tau_refrac == 7.0
    status = nest.GetStatus(root.circuit)
    assert status[0]['t_ref'] == 0.1 and abs(status[0]['V_m'] + 65) < 5
    nest.SetStatus([root.circuit[5]], {'V_th': 20.0})
    assert root.circuit.get('v_thresh').tolist() == [-50.0] * 5 + [20.0]
    connections = nest.GetConnections(source=root.source)
    assert nest.GetStatus(connections, 'weight') == (50.0,) * 6
    nest.SetStatus(connections, {'weight': 600.0})
    assert root.proj.getWeights() == [0.6] * 6
    assert set(nest.GetStatus(nest.GetConnections(source=root.net.left), 'weight')) == {-10.0}
    assert nest.GetKernelStatus('time') == 120.0
    assert [int(cell) for cell in root.net.left] == [1, 2, 3]
"""
IN_NEST = """
import nest
class Parts: pass
parts = Parts()
circuit = nest.Create('iaf_cond_alpha', 6)
parts.sensors = circuit[0:3]
pops = [circuit[0:2], circuit[2:]]
noise = nest.Create('poisson_generator', params={'rate': 100.})
detector = nest.Create('spike_detector')
nest.Connect(circuit, detector)
nest.Connect(noise, circuit, 'all_to_all', {'weight': 50.0, 'delay': 1.0})
nest.Connect(circuit[:3], circuit[3:], 'all_to_all', {'weight': -1.0, 'delay': 1.0})
def be_quiet(): nest.SetStatus(noise, {'rate': 0.0})
"""
OF_NEST = """
import nest
@nrp.MapSpikeSource("a", nrp.brain.pops[1], nrp.dc_source, amplitude=300.0)
@nrp.MapSpikeSource("b", nrp.brain.parts.sensors, nrp.dc_source)
@nrp.MapVariable("heard", initial_value=0)
@nrp.Robot2Neuron()
def function(t, a, b, heard):
    root = nrp.config.brain_root
    if abs(t - 0.1) < 1e-6:
        assert nest.GetStatus(root.noise, 'rate') == (100.0,)
        root.be_quiet()
        a.amplitude = 0
        heard.value = nest.GetStatus(root.detector, 'n_events')[0]
        events = nest.GetStatus(root.detector, 'events')[0]
        assert len(events['times']) == heard.value > 3 and set(events['senders']) <= set(root.circuit.nodes())
        synapses = nest.GetConnections(root.circuit, root.circuit)
        nest.SetStatus(synapses, 'weight', [-2.0] * 9)
        assert nest.GetStatus(synapses, 'weight') == (-2.0,) * 9
        nest.SetStatus(root.circuit, {'V_th': -54.0})
    if t > 0.19:
        assert nest.GetStatus(root.detector, 'n_events')[0] <= heard.value + 6
        assert nest.GetStatus(root.circuit, 'V_m')[0] < -60
"""


@pytest.fixture
def played(request: pytest.FixtureRequest, written: Written) -> Played:
    """Runs a brain file with one transfer function: ``played(brain, function)``."""

    def play(
        brain: str, function: str, mode: str = "", until_s: float = 0.2, overrides: Sequence[str] = ()
    ) -> Run:
        run = Run(read_exc(written(brain, function, mode), overrides))
        request.addfinalizer(run.close)
        run.run_until(until_s)
        return run

    return play


def test_populations_in_collections_and_objects_run_and_change_by_the_methods_of_pynn_and_nest(
    played: Played,
) -> None:
    run = played(IN_PYNN, OF_PYNN)
    assert not run.result().failures
    assert [function.name for function in run.loop.functions] == ["function"]
    cells = run.brain.network.neurons("circuit")
    (recorder,) = (sink for sink in run.brain.devices if sink.name == "brain/recorded/0")
    fired = recorder.spikes(130.0, 160.0).neurons  # type: ignore[union-attr]
    # the new train and weight excite all but the one whose threshold was raised
    assert set(fired) == set(cells[:5])


def test_populations_in_collections_are_driven_and_read_on_a_brain_that_cannot_change(played: Played) -> None:
    function = (
        OF_PYNN.partition("    root =")[0] + "    assert len(groups) == 3 and len(s.times) >= len(r.times)\n"
    )
    run = played(IN_PYNN, function, "<mode>SpiNNaker</mode>")
    assert (run.experiment.brain.backend, run.result().failures) == ("spinnaker", [])
    assert run.result().spikes["c"] == 2 * run.result().spikes["b"] > 0


def test_nodes_of_nest_run_and_change_by_its_calls(played: Played) -> None:
    run = played(IN_NEST, OF_NEST, "<mode>SynchronousDirectNestSimulation</mode>", 0.24)
    assert not run.result().failures
    assert run.loop.functions[0].adapters["heard"].value > 3  # type: ignore[attr-defined]
    before = run.brain.read_weights(run.brain.network.projections[-1].label)
    run.loop.reset()
    after = run.brain.read_weights(run.brain.network.projections[-1].label)
    assert (before[0], after[0]) == (pytest.approx(0.002), pytest.approx(0.001))
    run.run_until(0.24)
    assert not run.result().failures


EACH = """
import nest
@nrp.Robot2Neuron()
def function(t):
    cells = nrp.config.brain_root.circuit
    if abs(t - 0.1) < 1e-6:
        values = [-50.0, -51.0, -52.0, -53.0, -54.0, -55.0]
        nest.SetStatus(cells, {'V_th': values})
        assert nest.GetStatus(cells, 'V_th') == tuple(values)
        nest.SetStatus(cells, 'V_th', values[::-1])
        assert nest.GetStatus(cells, 'V_th') == tuple(values[::-1])
        nest.SetStatus(cells, {'V_th': nest.random.uniform(-55.0, -50.0)})
        assert len(set(nest.GetStatus(cells, 'V_th'))) == 6
"""


def test_values_for_each_node_are_set_while_the_brain_runs(played: Played) -> None:
    run = played(IN_NEST, EACH)
    assert not run.result().failures


BESIDE = """
import nest
from hbp_nrp_cle.brainsim import simulator as sim
noise = nest.Create('poisson_generator', 1, {'rate': 4000.0})
sim.setup(timestep=0.1)
circuit = sim.Population(3, sim.IF_cond_alpha(tau_syn_E=2.0), label='circuit')
more = nest.Create('iaf_cond_alpha', 2)
detector = nest.Create('spike_detector')
nest.Connect(noise, [int(cell) for cell in circuit], 'all_to_all', {'weight': 8.0})
nest.Connect(noise, more, 'all_to_all', {'weight': 8.0})
nest.Connect([int(cell) for cell in circuit], detector)
nest.Connect(more[:1], detector)
"""
OF_BESIDE = """
import nest
@nrp.MapSpikeSink("spikes", nrp.brain.circuit, nrp.spike_recorder)
@nrp.MapSpikeSink("other", nrp.brain.more[0], nrp.spike_recorder)
@nrp.MapVariable("counts", initial_value=[])
@nrp.Robot2Neuron()
def function(t, spikes, other, counts):
    root = nrp.config.brain_root
    own = len(spikes.times) + len(other.times)
    counts.value.append((own, nest.GetStatus(root.detector, 'n_events')[0]))
    events = nest.GetStatus(root.detector)[0]['events']
    assert set(events['senders']) <= {1, 2, 3, 4} and len(events['times']) == counts.value[-1][1]
    nest.SetStatus(root.detector, {'n_events': 0})
    if abs(t - 0.08) < 1e-6:
        assert nest.GetStatus(root.noise, 'rate') == (4000.0,)
        nest.SetStatus(root.noise, {'rate': 0.0})
        nest.SetStatus(root.noise, {})
        assert nest.GetStatus(root.noise, 'rate') == (0.0,)
"""


def test_nodes_beside_cells_of_pynn_are_read_emptied_and_changed_by_number(played: Played) -> None:
    run = played(BESIDE, OF_BESIDE)
    assert not run.result().failures
    counts = run.loop.functions[0].adapters["counts"].value  # type: ignore[attr-defined]
    own, heard = zip(*counts, strict=True)
    assert own == heard
    # the generator is silent from 0.1 s on, and the last input has decayed
    assert min(own[:4]) > 0
    assert own[-3:] == (0, 0, 0)


CELLS = """
from hbp_nrp_cle.brainsim import simulator as sim
sim.setup(timestep=0.1)
cells = sim.Population(2, sim.IF_curr_alpha(tau_m=20., cm=1.0, v_rest=-65., v_reset=-65.,
                                          v_thresh=-50., tau_refrac=2.0))
"""
NO_NUMBERS = """
@nrp.MapSpikeSource("p", nrp.brain.cells[0], nrp.poisson, weight=5.0)
@nrp.MapSpikeSource("each", nrp.map_neurons(range(2), lambda i: nrp.brain.cells[i]), nrp.fixed_frequency)
@nrp.MapSpikeSource("wave", nrp.brain.cells[1], nrp.ac_source)
@nrp.MapSpikeSource("noise", nrp.brain.cells[1], nrp.nc_source)
@nrp.Robot2Neuron()
def function(t, p, each, wave, noise):
    p.rate = -5.0 if t < 0.05 else float('nan') if t < 0.1 else 1e4
    each.rate = np.array([float('nan'), -1.0])
    wave.amplitude, noise.mean, noise.stdev = float('nan'), 0.0, -1.0
"""
CURRENT = """
@nrp.MapSpikeSource("current", nrp.brain.cells[0], nrp.dc_source, amplitude=1.0)
@nrp.MapSpikeSink("recorder", nrp.brain.cells, nrp.spike_recorder)
@nrp.MapVariable("times", initial_value=[])
@nrp.Robot2Neuron()
def function(t, current, recorder, times):
    times.value.extend(time for _, time in recorder.times)
"""


def test_rates_and_currents_that_no_device_can_have_count_as_none(
    played: Played, caplog: pytest.LogCaptureFixture
) -> None:
    run = played(CELLS, NO_NUMBERS)
    assert not run.result().failures
    counts = run.result().spikes
    assert counts["cells"] > 5
    assert "p: rate cannot be -5.0: set to 0.0" in caplog.text
    assert caplog.text.count("rate cannot be") == 3
    told = [one.message for one in run.result().problems if one.code is Code.NRP240]
    assert "p: rate cannot be -5.0: set to 0.0" in told
    assert sum("rate cannot be" in one for one in told) == 3


def test_spikes_under_a_constant_current_come_when_the_equation_says(played: Played) -> None:
    run = played(CELLS, CURRENT, until_s=0.5)
    times = run.loop.functions[0].adapters["times"].value  # type: ignore[attr-defined]
    # 1 nA into 1 nF leaks with 20 ms towards 20 mV above rest; 15 mV are needed, and 2 ms lie between
    period_ms = 20.0 * log(20.0 / (20.0 - 15.0)) + 2.0
    assert np.diff(times) == pytest.approx(period_ms, abs=1e-6)
    assert len(times) == run.result().spikes["cells"] == int((500.0 - times[0]) / period_ms) + 1


READ_OUT = """
from hbp_nrp_cle.brainsim import simulator as sim
sim.setup(timestep=0.1)
circuit = sim.Population(2, sim.IF_curr_exp())
outputs = [sim.Population(1, sim.IF_curr_exp(i_offset=0.1 * i, v_thresh=0.0)) for i in range(3)]
for output in outputs:
    output.record('v')
"""
READING_OUT = """
from hbp_nrp_cle.brainsim import simulator as sim
@nrp.MapVariable("outputs", initial_value=nrp.config.brain_root.outputs)
@nrp.MapVariable("read", initial_value=[])
@nrp.Neuron2Robot()
def function(t, outputs, read):
    signals = [output.get_data(clear=True).segments[-1].analogsignalarrays[0] for output in outputs.value]
    read.value.append([t, len(signals[0])] + [float(signal[-1]) for signal in signals])
"""


def test_functions_read_voltages_that_the_brain_file_records(played: Played) -> None:
    run = played(READ_OUT, READING_OUT, until_s=0.1)
    rows = np.array(run.loop.functions[0].adapters["read"].value)  # type: ignore[attr-defined]
    # 20 ms at 0.1 ms each, because the data are cleared, and the value at time 0
    assert rows[:, 1].tolist() == [201, 200, 200, 200, 200]
    # i nA / 10 into 1 nF that leaks with 20 ms: towards 2 mV i above the resting potential of -65 mV
    expected = -65.0 + np.outer(1.0 - np.exp(-np.arange(1, 6)), 2.0 * np.arange(3))
    assert rows[:, 2:] == pytest.approx(expected, abs=1e-6)


KEPT = """
from collections import namedtuple
import os, sys
sys.path.append(os.path.join(os.path.dirname(__file__), 'PLACE'))
Layers = namedtuple('Layers', 'input size')
layers = Layers(cells, 2)
history, counts = [], {'calls': 0}
def heard(): return len(history)
"""
KEEPING = """
import where
import numpy.random
@nrp.MapSpikeSource("a", nrp.brain.layers.input, nrp.dc_source)
@nrp.MapCSVRecorder("rows", filename="rows.csv", headers=["place", "heard"])
@nrp.Robot2Neuron()
def function(t, a, rows):
    root = nrp.config.brain_root
    root.history.append(t)
    root.counts['calls'] += 1
    assert root.heard() == root.counts['calls']
    root.layers.input.set(tau_m=10.)
    assert root.layers.input.get('tau_m') == 10. and root.cells[[]].get('tau_m').size == 0
    assert 0 <= numpy.random.rand() < 1
    rows.record_entry(where.name, root.heard())
"""


def test_items_that_functions_add_to_lists_of_the_brain_file_stay_there(
    played: Played, tmp_path: Path
) -> None:
    _places(tmp_path)
    run = played(CELLS + KEPT.replace("PLACE", "here"), KEEPING)
    assert not run.result().failures
    assert run.loop.functions[0].adapters["rows"].rows[-1] == ["here", "10"]  # type: ignore[attr-defined]


def test_experiments_of_one_process_search_modules_each_in_its_own_folders(
    played: Played, tmp_path: Path
) -> None:
    _places(tmp_path)
    before = list(sys.path)
    for place in ("here", "there"):
        run = played(CELLS + KEPT.replace("PLACE", place), KEEPING)
        assert run.loop.functions[0].adapters["rows"].rows[-1][0] == place  # type: ignore[attr-defined]
        assert (sys.path, "where" in sys.modules) == (before, False)


def _places(folder: Path) -> None:
    for place in ("here", "there"):
        (folder / place).mkdir()
        (folder / place / "where.py").write_text(f"name = {place!r}")


def test_a_parameter_that_no_cell_has_is_refused_by_its_name(played: Played) -> None:
    function = "@nrp.Robot2Neuron()\ndef function(t):\n    nrp.config.brain_root.cells.get('tau_x')\n"
    (failure,) = played(CELLS, function).result().failures
    assert "brain.cells has no parameter 'tau_x'; did you mean 'tau_m'?" in str(failure)


@pytest.mark.parametrize("seed", [-3, 5_000_000_000])
def test_any_integer_is_a_seed(played: Played, tmp_path: Path, seed: int) -> None:
    _places(tmp_path)
    run = played(CELLS + KEPT.replace("PLACE", "here"), KEEPING, overrides=[f"seed={seed}"])
    assert not run.result().failures
    assert [function.name for function in run.loop.functions] == ["function"]
