"""PyNN's composed cells: against its cells of one piece, closed formulas, and NEST through PyNN."""

from __future__ import annotations

from math import e, exp, log
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.pynn import new_simulator

NEST_SPIKES_MS = [34.0, 112.0]
NEST_V_MV = {29.0: -59.984518, 33.0: -49.020363, 89.0: -62.538978, 105.0: -51.641020, 150.0: -66.178266}
"""Of PyNN 0.13 with NEST 3.10 (``aeif_cond_alpha_multisynapse``), for the cell of `adexp`."""


@pytest.fixture
def sim() -> Any:
    simulator = new_simulator()
    simulator.setup(timestep=0.1)
    return simulator


def connect(sim: Any, cells: Any, weights: dict[str, tuple[float, float]]) -> None:
    """Connect a source to each receptor, with a weight and the time of its spike, ms."""
    for receptor, (weight, time) in weights.items():
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[time]))
        static = sim.StaticSynapse(weight=weight, delay=1.5)
        sim.Projection(source, cells, sim.AllToAllConnector(), static, receptor_type=receptor)


def recorded(cells: Any) -> dict[str, np.ndarray]:
    segment = cells.get_data().segments[0]
    return {signal.name: np.asarray(signal)[:, 0] for signal in segment.analogsignals}


def adexp(sim: Any) -> Any:
    return sim.PointNeuron(
        sim.AdExp(tau_m=10.0, v_rest=-60.0),
        AMPA=sim.AlphaPSR(tau_syn=1.0, e_syn=0.0),
        NMDA=sim.AlphaPSR(tau_syn=20.0, e_syn=0.0),
        GABAA=sim.AlphaPSR(tau_syn=1.5, e_syn=-70.0),
        GABAB=sim.AlphaPSR(tau_syn=15.0, e_syn=-90.0),
    )


@pytest.mark.heavy
def test_four_receptors_act_as_in_nest(sim: Any) -> None:
    cells = sim.Population(1, adexp(sim), initial_values={"v": -60.0})
    cells.record(["spikes", "v", "w", *(f"{name}.gsyn" for name in ("AMPA", "NMDA", "GABAA", "GABAB"))])
    weights = {"AMPA": (0.05, 30.0), "GABAA": (0.1, 60.0), "NMDA": (0.01, 90.0), "GABAB": (0.02, 120.0)}
    connect(sim, cells, weights)
    sim.run(200.0)
    data = recorded(cells)
    np.testing.assert_allclose(cells.get_data().segments[0].spiketrains[0].magnitude, NEST_SPIKES_MS)
    for time, voltage in NEST_V_MV.items():
        assert data["v"][round(time * 10)] == pytest.approx(voltage, abs=1e-3)
    times = 0.1 * np.arange(2001)
    for name, tau in (("AMPA", 1.0), ("NMDA", 20.0), ("GABAA", 1.5), ("GABAB", 15.0)):
        weight, time = weights[name]
        since = np.maximum(times - time - 1.5, 0.0) / tau
        np.testing.assert_allclose(data[f"{name}.gsyn"], weight * since * np.exp(1.0 - since), atol=1e-8)


def test_a_cell_composed_like_one_of_one_piece_is_equal_to_it(sim: Any) -> None:
    parameters = {"tau_m": 10.0, "v_rest": -60.0, "i_offset": 1.5, "tau_refrac": 2.0}
    whole = sim.Population(1, sim.IF_curr_exp(**parameters, tau_syn_E=1.0, tau_syn_I=2.0))
    parts = {name: sim.CurrExpPostSynapticResponse(tau_syn=tau) for name, tau in (("A", 1.0), ("B", 2.0))}
    composed = sim.Population(1, sim.PointNeuron(sim.LIF(**parameters), **parts))
    for cells, names in ((whole, ("excitatory", "inhibitory")), (composed, ("A", "B"))):
        cells.record(["spikes", "v"])
        connect(sim, cells, {names[0]: (2.0, 30.0), names[1]: (-0.9, 50.0)})
    sim.run(120.0)
    trains = [cells.get_data().segments[0].spiketrains[0].magnitude for cells in (whole, composed)]
    assert len(trains[0]) > 3
    np.testing.assert_allclose(*trains, atol=1e-9)
    np.testing.assert_allclose(recorded(whole)["v"], recorded(composed)["v"], atol=1e-9)


@pytest.mark.one_of(8)
@pytest.mark.parametrize("tau_rise", [0.7, 6.0, 6.001, 9.0])
def test_the_peak_of_a_beta_function_is_the_weight(sim: Any, tau_rise: float) -> None:
    response = sim.BetaPSR(tau_rise=tau_rise, tau_decay=6.0)
    cells = sim.Population(1, sim.PointNeuron(sim.LIF(), AMPA=response))
    cells.record("AMPA.gsyn")
    connect(sim, cells, {"AMPA": (0.003, 3.5)})
    sim.run(60.0)
    t = 10.0
    if tau_rise == 6.0:
        expected = t / 6.0 * exp(1.0 - t / 6.0)
    else:
        peak = log(6.0 / tau_rise) * 6.0 * tau_rise / (6.0 - tau_rise)
        height = exp(-peak / 6.0) - exp(-peak / tau_rise)
        expected = (exp(-t / 6.0) - exp(-t / tau_rise)) / height
    found = recorded(cells)["AMPA.gsyn"]
    assert found[150] == pytest.approx(0.003 * expected, rel=1e-6)
    assert found.max() == pytest.approx(0.003, rel=1e-3)


@pytest.mark.heavy  # compiles for 10 s
def test_plastic_synapses_learn_at_every_receptor(sim: Any) -> None:
    names = ("W", "X", "Y", "Z")
    kind = sim.PointNeuron(sim.LIF(i_offset=0.9), **{name: sim.ExpPSR() for name in names})
    cells = sim.Population(3, kind)
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=[20.0, 50.0, 90.0, 140.0]))
    stdp = sim.STDPMechanism(
        sim.SpikePairRule(A_plus=0.1, A_minus=0.1), sim.AdditiveWeightDependence(w_max=0.01), weight=0.005
    )
    learning = [
        sim.Projection(source, cells, sim.AllToAllConnector(), stdp, receptor_type=name) for name in names
    ]
    sim.run(160.0)
    weights = np.array([projection.get("weight", "array")[0] for projection in learning])
    assert (weights != 0.005).all()
    np.testing.assert_array_equal(weights, np.broadcast_to(weights[:1, :1], weights.shape))


@pytest.mark.heavy
def test_parameters_and_initial_values_have_the_name_of_their_receptor(sim: Any) -> None:
    kind = sim.PointNeuron(sim.LIF(), AMPA=sim.ExpPSR(tau_syn=sim.RandomDistribution("uniform", (2.0, 4.0))))
    cells = sim.Population(2, kind, initial_values={"AMPA.gsyn": 0.01})
    taus = cells.get("AMPA.tau_syn")
    assert ((taus > 2.0) & (taus < 4.0)).all()
    assert taus[0] != taus[1]
    cells.record("AMPA.gsyn")
    cells.set(**{"AMPA.tau_syn": 5.0})
    sim.run(10.0)
    cells[0:1].set(**{"AMPA.tau_syn": 2.0})
    sim.run(10.0)
    found = np.asarray(cells.get_data().segments[0].filter(name="AMPA.gsyn")[0])[-1]
    np.testing.assert_allclose(found, [0.01 * e**-7.0, 0.01 * e**-4.0], rtol=1e-9)


def test_parts_that_cannot_be_composed_are_named(sim: Any, golden: Golden) -> None:
    current, conductance = sim.CurrExpPostSynapticResponse(), sim.ExpPSR()
    with golden.raises(NetworkError):
        sim.PointNeuron(sim.LIF(), A=current, B=conductance)
    with golden.raises(TypeError, match="IF_cond_exp.*LIF, AdExp"):
        sim.PointNeuron(sim.IF_cond_exp(), A=conductance)
    with golden.raises(NetworkError, match="CondExpPostSynapticResponse.*'tau'"):
        sim.ExpPSR(tau=3.0)
    cells = sim.Population(1, adexp(sim), label="cells")
    with golden.raises(NetworkError, match="'AMAP'.*'AMPA'"):
        sim.Projection(cells, cells, sim.AllToAllConnector(), receptor_type="AMAP")


def test_a_fifth_receptor_is_refused_by_name(sim: Any, golden: Golden) -> None:
    sim.Population(1, sim.PointNeuron(sim.LIF(), **{f"R{k}": sim.ExpPSR() for k in range(5)}), label="many")
    with golden.raises(CapabilityError, match="'many'.*'event'"):
        sim.run(1.0)
