"""Values of cells and synapses in another unit than PyNN's are reported, and usual ones are not."""

from __future__ import annotations

import pytest

from nrp_core.checks.network_units import unlikely_units
from nrp_core.network.pynn import builder

CELLS = {
    "IF_curr_exp(tau_m=0.02)": "tau_m of the population 'cells' is 0.02 ms; is it meant in s?",
    "IF_curr_exp(cm=1e-4)": "cm of the population 'cells' is 0.0001 nF; is it meant in uF?",
    "IF_curr_exp(cm=250.0)": "cm of the population 'cells' is 250 nF; is it meant in pF?",
    "IF_curr_exp(tau_refrac=0.002)": "tau_refrac of the population 'cells' is 0.002 ms; is it meant in s?",
    "IF_curr_exp(i_offset=500.0)": "i_offset of the population 'cells' is 500 nA; is it meant in pA?",
    "IF_cond_exp(e_rev_I=-0.08)": "e_rev_I of the population 'cells' is -0.08 mV; is it meant in V?",
    "IF_curr_exp(v_rest=-65000.0)": "v_rest of the population 'cells' is -65000 mV; is it meant in uV?",
    "IF_curr_exp(v_rest=0.0, v_thresh=15e3)": "v_thresh of the population 'cells' is 15000 mV; is it",
    "SpikeSourcePoisson(rate=1e6)": "rate of the population 'cells' is 1e+06 Hz; is it meant in mHz?",
    "SpikeSourceArray(spike_times=[0.1, 0.2, 0.3])": "follow each other after 0.1 ms; is it meant in s?",
}
SYNAPSES = {
    "StaticSynapse(weight=500.0)": "500 nA, with which one spike moves a cell by 1.57e+03 mV; is it",
    "StaticSynapse(weight=0.5, delay=0.02)": "is 0.02 ms, shorter than the time step of 0.1 ms",
    "StaticSynapse(weight=0.5, delay=1500.0)": "a delay of the projection 'p' is 1500 ms; is it meant in us?",
    "TsodyksMarkramSynapse(weight=0.5, tau_rec=0.8)": "tau_rec of the projection 'p' is 0.8 ms; is it meant",
}
USUAL = [
    "IF_curr_exp()", "IF_cond_alpha()", "Izhikevich()", "HH_cond_exp()", "EIF_cond_exp_isfa_ista()",
    "IF_curr_delta()", "SpikeSourcePoisson(rate=2e4)", "IF_curr_exp(v_thresh=float('inf'))",
    "IF_curr_exp(v_thresh=1e6)", "IF_cond_exp(v_thresh=1e10)",
]  # fmt: skip


def found(kind: str, synapse: str = "StaticSynapse(weight=0.5)") -> list[str]:
    sim = builder()
    sim.setup(timestep=0.1)
    cells = eval(f"sim.Population(2, sim.{kind}, label='cells')", {"sim": sim})
    post = sim.Population(2, sim.IF_curr_exp(), label="post")
    law = eval(f"sim.{synapse}", {"sim": sim})
    sim.Projection(cells, post, sim.AllToAllConnector(), law, label="p")
    return unlikely_units(sim.network())


@pytest.mark.parametrize("kind", USUAL)
def test_usual_cells_are_not_reported(kind: str) -> None:
    assert found(kind) == []


@pytest.mark.parametrize("kind", CELLS)
def test_cells_in_another_unit_are_reported(kind: str) -> None:
    assert [CELLS[kind] in one for one in found(kind)] == [True]


@pytest.mark.parametrize("synapse", SYNAPSES)
def test_synapses_in_another_unit_are_reported(synapse: str) -> None:
    assert [SYNAPSES[synapse] in one for one in found("IF_curr_exp()", synapse)] == [True]


@pytest.mark.parametrize(("weight", "count"), [(0.01, 0), (10.0, 0), (50.0, 1)])
def test_conductances_may_be_far_beyond_what_saturates_a_cell(weight: float, count: int) -> None:
    """PyNN's example of plasticity makes a cell fire with 10 uS."""
    sim = builder()
    pre, post = sim.Population(1, sim.IF_cond_exp()), sim.Population(1, sim.IF_cond_exp())
    sim.Projection(pre, post, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight))
    assert len(unlikely_units(sim.network())) == count


@pytest.mark.parametrize("weight", [20.0, 100.0])
def test_weights_with_which_each_spike_makes_a_cell_fire_are_not_reported(weight: float) -> None:
    assert found("IF_curr_exp()", f"StaticSynapse(weight={weight})") == []
