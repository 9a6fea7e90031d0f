"""The effect of one spike on a cell, against closed forms, quadrature and a simulated cell."""

from __future__ import annotations

from math import exp
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from nrp_core.checks.synaptic_effects import distance_to_threshold_mv, effect_of_spike
from nrp_core.network.pynn import builder


def cells(kind: str, **parameters: float) -> Any:
    sim = builder()
    sim.Population(2, getattr(sim, kind)(**parameters), label="cells")
    return sim.network().populations["cells"]


@pytest.mark.parametrize("tau_syn", [0.1, 2.5, 5.0, 20.0, 50.0])
@pytest.mark.parametrize("kind", ["IF_curr_exp", "IF_curr_alpha"])
def test_the_potential_is_the_convolution_of_current_and_membrane(kind: str, tau_syn: float) -> None:
    tau_m, cm = 20.0, 0.5

    def current(t: float) -> float:
        return exp(-t / tau_syn) if kind == "IF_curr_exp" else t / tau_syn * exp(1.0 - t / tau_syn)

    def potential(t: float) -> float:
        return quad(lambda s: current(s) * exp(-(t - s) / tau_m), 0.0, t, limit=200)[0] / cm

    lowest = minimize_scalar(lambda t: -potential(t), bounds=(0.0, 10 * (tau_m + tau_syn)), method="bounded")
    charge = quad(current, 0.0, 60.0 * tau_syn, limit=500)[0]
    found = effect_of_spike(cells(kind, cm=cm, tau_m=tau_m, tau_syn_E=tau_syn), "excitatory")
    assert found is not None
    assert found.peak_mv == pytest.approx(-lowest.fun, rel=1e-3)
    assert found.area_mv_ms == pytest.approx(charge * tau_m / cm, rel=1e-6)


def test_the_inhibition_of_brunels_network_is_27_mv() -> None:
    """PyNN's example has a weight of g J / tau_syn * 0.0004136 with g = 5 and J = 5 mV on 1 pF."""
    post = cells("IF_curr_alpha", cm=0.001, tau_m=20.0, tau_syn_I=0.1, v_rest=0.0, v_thresh=20.0)
    effect = effect_of_spike(post, "inhibitory")
    weight = 5.0 * (5.0 / 0.1) * 0.00041363506632638
    assert effect is not None
    assert weight * effect.peak_mv == pytest.approx(27.3, abs=0.1)


@pytest.mark.parametrize(
    ("kind", "weight"),
    [("IF_curr_exp", 0.05), ("IF_curr_alpha", 0.05), ("IF_cond_exp", 1e-6), ("IF_cond_alpha", 1e-6)],
)
def test_a_simulated_cell_has_this_peak(kind: str, weight: float) -> None:
    import nrp_core.pynn as sim

    sim.setup(timestep=0.1, backend="event")
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=[1.0]))
    cell = sim.Population(1, getattr(sim, kind)(tau_m=15.0, cm=0.3, v_rest=-65.0), label="cells")
    cell.initialize(v=-65.0)
    cell.record("v")
    sim.Projection(source, cell, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight, delay=1.0))
    sim.run(60.0)
    v = np.asarray(cell.get_data().segments[0].analogsignals[0]).ravel()
    effect = effect_of_spike(sim.simulator.state.brain.network.populations["cells"], "excitatory")
    sim.end()
    assert effect is not None
    assert v.max() + 65.0 == pytest.approx(weight * effect.peak_mv, rel=5e-3)


def test_a_weight_in_mv_is_the_peak() -> None:
    effect = effect_of_spike(cells("IF_curr_delta", tau_m=20.0), "excitatory")
    assert effect == (1.0, 20.0)


def test_the_effect_is_unknown_for_other_cells() -> None:
    assert effect_of_spike(cells("Izhikevich"), "excitatory") is None
    assert effect_of_spike(cells("EIF_cond_exp_isfa_ista"), "excitatory") is None


def test_a_constant_current_brings_cells_nearer_to_their_threshold() -> None:
    """V = v_rest + i_offset tau_m / cm."""
    assert distance_to_threshold_mv(cells("IF_curr_exp", v_rest=-65.0, v_thresh=-50.0)) == pytest.approx(15.0)
    near = cells("IF_curr_exp", v_rest=-65.0, v_thresh=-50.0, tau_m=20.0, cm=1.0, i_offset=0.5)
    assert distance_to_threshold_mv(near) == pytest.approx(5.0)
