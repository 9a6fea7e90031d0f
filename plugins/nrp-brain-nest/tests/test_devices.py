"""Devices reach NEST's cells at the times the grid allows, at any time of the run."""

import numpy as np
import pytest
from nrp_core.brain import DCSource, FixedFrequencySource, LeakyIntegratorAlpha, PoissonSource, SpikeRecorder
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError

from standard_cells import CELLS, weight_for


def one_cell(cell_type="IF_curr_exp", n=1, **parameters):
    return lambda sim: sim.Population(n, getattr(sim, cell_type)(**parameters), label="cells")


def voltage_after(brain, ms):
    brain.run_until(round(ms * NS_PER_MS))
    return brain.read_state("v", [0])[0]


@pytest.mark.parametrize("receptor", ["excitatory", "inhibitory"])
@pytest.mark.parametrize("cell_type", [name for name in CELLS if name != "Izhikevich"])
def test_events_on_the_grid_have_the_effect_of_the_exact_engine(cell_type, receptor, network, opened):
    made, values = network(one_cell(cell_type)), []
    source = FixedFrequencySource(
        rate=200.0, weight=weight_for(cell_type, receptor), delay=0.5, receptor_type=receptor
    )
    for backend in ("event", "nest"):
        brain = opened(made, backend)
        brain.add_source(source, [0], name="ticks")
        values.append([voltage_after(brain, ms) for ms in (4, 8, 23)])
    np.testing.assert_allclose(values[1], values[0], rtol=0, atol=1e-9 if "curr" in cell_type else 1e-3)


def test_an_event_between_grid_points_arrives_at_the_next_one(network, opened):
    brain = opened(network(one_cell("IF_curr_delta")))
    brain.add_source(FixedFrequencySource(rate=1000 / 3.14, weight=5.0, delay=0.1), [0], name="ticks")
    rest = voltage_after(brain, 3.2)
    assert voltage_after(brain, 3.3) - rest == pytest.approx(5.0)  # 3.24 ms


def test_a_current_acts_from_now_on_and_leaves_no_trace(network, opened):
    made, values = network(one_cell(n=2, i_offset=0.1)), []
    for backend in ("event", "nest"):
        brain = opened(made, backend)
        brain.run_until(10 * NS_PER_MS)
        source = brain.add_source(DCSource(amplitude=[0.5, 0.25]), [0, 1], name="electrode")
        brain.run_until(20 * NS_PER_MS)
        brain.remove(source)
        for _ in range(3):
            values.append(brain.read_state("v", [0, 1]))
            brain.run_until(brain.now_ns + 10 * NS_PER_MS)
    np.testing.assert_allclose(values[3:], values[:3], rtol=0, atol=1e-9)


def test_a_device_can_come_late_and_go(network, opened):
    brain = opened(network(one_cell("IF_curr_delta", tau_m=1.0)))
    assert voltage_after(brain, 20) == -65.0
    source = brain.add_source(FixedFrequencySource(rate=1000.0, weight=1.0, delay=0.1), [0], name="late")
    assert voltage_after(brain, 40.1) > -64.5
    brain.remove(source)
    assert voltage_after(brain, 80) == pytest.approx(-65.0)


def test_how_a_run_is_split_does_not_change_it(network, opened):
    made = network(one_cell("IF_cond_exp", n=5))
    trains = []
    for step_ms in (200.0, 20.0, 0.3):
        brain = opened(made)
        brain.add_source(PoissonSource(rate=2000.0, weight=0.02, delay=0.1), range(5), name="noise")
        recorder = brain.add_sink(SpikeRecorder(), range(5), name="recorder")
        while brain.now_ns < 200 * NS_PER_MS:
            brain.run_until(min(brain.now_ns + round(step_ms * NS_PER_MS), 200 * NS_PER_MS))
        brain.close()
        trains.append(recorder.spikes())
    assert len(trains[0]) > 10
    for train in trains[1:]:
        assert train.neurons.tolist() == trains[0].neurons.tolist()
        assert train.times_ms.tolist() == trains[0].times_ms.tolist()


def test_spikes_reach_a_sink_in_the_window_in_which_they_happen(network, opened):
    brain = opened(network(one_cell(i_offset=2.0)))
    recorder = brain.add_sink(SpikeRecorder(), [0], name="recorder")
    integrator = brain.add_sink(LeakyIntegratorAlpha(), [0], name="integrator")
    seen = []
    for step in range(1, 501):
        brain.run_until(step * 100_000)
        new = recorder.spikes((step - 1) * 0.1 + 1e-6).times_ms.tolist()
        assert new in ([], [pytest.approx(step * 0.1)])
        seen += new
    assert len(seen) > 2
    assert integrator.voltage > 0


def test_a_weight_of_the_wrong_sign_is_refused_where_nest_would_use_the_other_receptor(network, opened):
    brain = opened(network(one_cell(tau_syn_I=2.0)))
    brain.add_source(FixedFrequencySource(rate=100.0, weight=-1.0, delay=0.1), [0], name="wrong")
    with pytest.raises(CapabilityError, match=r"-1.*'cells'"):
        brain.run_until(20 * NS_PER_MS)


def test_a_weight_of_any_sign_is_right_where_receptors_do_not_differ(network, opened):
    brain = opened(network(one_cell()))
    brain.add_source(FixedFrequencySource(rate=100.0, weight=-1.0, delay=0.1), [0], name="either")
    assert voltage_after(brain, 20) < -65.0
