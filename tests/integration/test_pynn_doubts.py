"""A script that runs by itself is told what is doubtful in its network, as an experiment is."""

from __future__ import annotations

from typing import Any

import pytest

from nrp_core.errors import NetworkError
from nrp_core.pynn import new_simulator


def network(**synapse: Any) -> tuple[Any, Any]:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    noise = sim.Population(4, sim.SpikeSourcePoisson(rate=50.0), label="noise")
    cells = sim.Population(4, sim.IF_cond_exp(), label="cells")
    values = {"weight": 0.01, "delay": 1.0, **synapse}
    sim.Projection(noise, cells, sim.AllToAllConnector(), sim.StaticSynapse(**values), label="p")
    return sim, cells


def told(sim: Any, caplog: pytest.LogCaptureFixture) -> list[str]:
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        sim.run(1.0)
        sim.reset()
        sim.run(1.0)
    return [one.getMessage() for one in caplog.records if one.name.startswith("nrp_core.pynn")]


def test_a_script_without_doubt_is_told_nothing(caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network()
    sim.DCSource(amplitude=0.5, start=0.2).inject_into(cells)
    assert told(sim, caplog) == []


def test_each_doubt_is_told_once(caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network(delay=0.015)
    sim.Population(2, sim.IF_cond_exp(tau_m=0.02), label="cells")
    sim.DCSource(amplitude=500.0).inject_into(cells)
    sim.NoisyCurrentSource(mean=0.1, stdev=0.1)
    assert told(sim, caplog) == [
        "two populations have the label 'cells'; the later one is called 'cells 2'",
        "a NoisyCurrentSource (the current source 2 of 2) is never injected: call its inject_into(cells)",
        "tau_m of the population 'cells 2' is 0.02 ms; is it meant in s?",
        "a delay of the projection 'p' is 0.015 ms, shorter than the time step of 0.1 ms; is it meant in s?",
        "amplitude of a DCSource is 500 nA; is it meant in pA?",
    ]


def test_plasticity_in_other_units_is_told(caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network()
    learning = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(tau_plus=20_000.0, tau_minus=20.0, A_plus=0.01, A_minus=0.01),
        weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=100.0), weight=0.01, delay=1.0,
    )  # fmt: skip
    sim.Projection(cells, cells, sim.AllToAllConnector(), learning, label="learning")
    fast = sim.TsodyksMarkramSynapse(U=0.5, tau_rec=0.1, tau_facil=0.0, weight=0.01, delay=1.0)
    sim.Projection(cells, cells, sim.AllToAllConnector(), fast, label="fast")
    assert told(sim, caplog) == [
        "tau_plus of the projection 'learning' is 20000 ms; is it meant in us?",
        "w_max of the projection 'learning' is 100 uS, 2e+03 times the leak of a cell; is it meant in nS?",
        "tau_rec of the projection 'fast' is 0.1 ms; is it meant in s?",
    ]


def test_cells_of_a_network_that_is_gone_record_nothing() -> None:
    sim, cells = network()
    sim.setup(timestep=0.1)
    with pytest.raises(NetworkError, match=r"'cells' was built before the last setup\(\)"):
        cells.record("v")


def test_a_current_ends_after_it_begins() -> None:
    sim, _ = network()
    with pytest.raises(ValueError, match="DCSource: stop is 10 ms, before start, 20 ms"):
        sim.DCSource(amplitude=0.5, start=20.0, stop=10.0)
    source = sim.DCSource(amplitude=0.5, start=20.0)
    with pytest.raises(ValueError, match="DCSource: stop is 10 ms, before start, 20 ms"):
        source.stop = 10.0


def test_an_instance_of_cells_takes_no_further_parameters() -> None:
    sim, _ = network()
    with pytest.raises(
        ValueError, match=r"'more': give its parameters to IF_cond_exp\(...\), not as cellpar"
    ):
        sim.Population(2, sim.IF_cond_exp(), cellparams={"tau_m": 10.0}, label="more")
