"""NEST and the exact engine agree, within NEST's resolution."""

import numpy as np
import pytest

from standard_cells import CELLS, weight_for

CURRENT_NA = {"IF_curr_exp": 1.0, "IF_curr_alpha": 1.0, "IF_curr_delta": 1.0, "Izhikevich": 0.01}
INTEGRATE_AND_FIRE = [name for name in CELLS if name.startswith(("IF", "EIF"))]


def driven(cell_type):
    current = CURRENT_NA.get(cell_type, 1.2)
    return lambda sim: sim.Population(1, getattr(sim, cell_type)(i_offset=current), label="cells")


def one_input(cell_type, receptor, synapse=None, times=(3.0,)):
    def build(sim):
        cells = sim.Population(1, getattr(sim, cell_type)(), label="cells")
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=list(times)))
        weight = weight_for(cell_type, receptor)
        kind = synapse(sim, weight) if synapse else sim.StaticSynapse(weight=weight, delay=1.5)
        sim.Projection(source, cells, sim.OneToOneConnector(), kind, receptor_type=receptor)

    return build


@pytest.mark.parametrize("step_ms", [0.1, 0.02])
@pytest.mark.parametrize("cell_type", INTEGRATE_AND_FIRE)
def test_each_interval_is_rounded_up_to_the_grid_once(cell_type, step_ms, network, spike_times):
    made = network(driven(cell_type))
    exact, found = spike_times(made, "event"), spike_times(made, resolution=f"{step_ms} ms")
    assert len(found) > 2
    late = found - exact[: len(found)]
    allowed = step_ms * (1 + np.arange(len(found)))
    assert (late > -1e-4).all()  # the step of NEST's solver has an error, too
    assert (late <= allowed + 1e-6).all()


@pytest.mark.parametrize(("cell_type", "share"), [("Izhikevich", 0.15), ("HH_cond_exp", 0.6)])
def test_a_finer_grid_brings_intervals_closer_to_the_exact_ones(cell_type, share, network, spike_times):
    made = network(driven(cell_type))
    exact = np.diff(spike_times(made, "event"))
    coarse, fine = (np.diff(spike_times(made, resolution=step)) for step in ("0.1 ms", "0.01 ms"))
    errors = [np.abs(found - exact[: len(found)]).max() for found in (coarse, fine)]
    assert errors[1] < share * errors[0] < 0.2


def test_hodgkin_huxley_spikes_are_reported_at_the_peak(network, spike_times):
    made = network(driven("HH_cond_exp"))
    exact, found = spike_times(made, "event"), spike_times(made, resolution="0.01 ms")
    late = found - exact[: len(found)]
    assert len(found) == len(exact)
    assert ((late > 0.05) & (late < 0.4)).all()


@pytest.mark.parametrize("receptor", ["excitatory", "inhibitory"])
@pytest.mark.parametrize("cell_type", CELLS)
def test_a_synapse_has_the_same_effect(cell_type, receptor, network, voltages):
    made = network(one_input(cell_type, receptor))
    exact = voltages(made, "event")
    # Euler steps of the Izhikevich model; adaptive Runge-Kutta of the conductance-based ones; closed forms
    finest = {"Izhikevich": "0.01 ms"}.get(cell_type, "0.1 ms")
    tolerance = {"Iz": 0.02, "HH": 1e-3}.get(cell_type[:2], 1e-9 if "curr" in cell_type else 1e-3)
    found = voltages(made, resolution=finest)
    assert np.ptp(exact) > 0.02
    np.testing.assert_allclose(found, exact, rtol=0, atol=tolerance)


@pytest.mark.parametrize("cell_type", ["IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp"])
@pytest.mark.parametrize("tau_facil", [0.0, 200.0])
def test_a_tsodyks_markram_synapse_has_the_same_effect(cell_type, tau_facil, network, voltages):
    def synapse(sim, weight):
        return sim.TsodyksMarkramSynapse(weight=weight, delay=1.5, U=0.4, tau_rec=80.0, tau_facil=tau_facil)

    made = network(one_input(cell_type, "excitatory", synapse, times=(2.0, 5.0, 9.0, 20.0)))
    exact, found = voltages(made, "event"), voltages(made)
    assert np.ptp(exact) > 0.2
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9 if "curr" in cell_type else 1e-3)


def test_resources_that_recover_as_fast_as_they_act_need_no_special_case(network, voltages):
    def synapse(sim, weight):  # tau_rec is the target's tau_syn_E
        return sim.TsodyksMarkramSynapse(weight=weight, delay=1.0, U=0.5, tau_rec=5.0, tau_facil=0.0)

    made = network(one_input("IF_curr_exp", "excitatory", synapse, times=(2.0, 5.0, 9.0)))
    np.testing.assert_allclose(voltages(made), voltages(made, "event"), rtol=0, atol=1e-5)


@pytest.mark.parametrize("variable", ["gsyn_exc", "gsyn_inh", "w", "v"])
def test_state_is_read_in_the_units_of_pynn(variable, network, opened):
    def build(sim):
        cells = sim.Population(2, sim.EIF_cond_alpha_isfa_ista(a=30.0), label="cells")
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[1.0]))
        for receptor in ("excitatory", "inhibitory"):
            static = sim.StaticSynapse(weight=0.004, delay=1.0)
            sim.Projection(source, cells, sim.AllToAllConnector(), static, receptor_type=receptor)

    made, values = network(build), []
    for backend in ("event", "nest"):
        brain = opened(made, backend)
        brain.run_until(4_000_000)
        values.append(brain.read_state(variable, [1, 0, 1]))
    assert values[0].shape == (3,)
    np.testing.assert_allclose(values[1], values[0], rtol=2e-3)
