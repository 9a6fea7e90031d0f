"""Synapse laws given as equations: our own laws as equations, a closed formula, snapshots, weights."""

from __future__ import annotations

from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_brain_event import EventBackend, equation_synapses

from nrp_core import read_network, save_network
from nrp_core.brain import builder
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.network.data import Network

MODES: list[dict[str, Any]] = [{}, {"resolution": "0.1 ms", "lazy": "never"}]
TRACES = """
dr1/dt = -r1/tau_plus : 1 (event-driven)
do1/dt = -o1/tau_minus : 1 (event-driven)
"""
SLOW = """
dr2/dt = -r2/tau_x : 1 (event-driven)
do2/dt = -o2/tau_y : 1 (event-driven)
"""
PAIRS = {"tau_plus": "17 ms", "tau_minus": "34 ms", "A_plus": 0.02, "A_minus": 0.011}
TRIPLETS = {**PAIRS, "A3_plus": 0.03, "A3_minus": 0.007, "tau_x": "101 ms", "tau_y": "125 ms"}
LIMITS = {"w_min": "0 mV", "w_max": "2000 uV"}
TSODYKS_MARKRAM = {"U": 0.4, "tau_rec": "120 ms", "tau_facil": "60 ms"}


def numbers(parameters: dict[str, Any]) -> dict[str, float]:
    return {name: float(str(value).split()[0]) for name, value in parameters.items()}


def tsodyks_markram(sim: Any, *, own: bool) -> Any:
    if not own:
        return sim.TsodyksMarkramSynapse(weight=1.5, delay=1.0, **numbers(TSODYKS_MARKRAM))
    law = sim.EquationSynapse(
        """
        du/dt = -u/tau_facil : 1 (event-driven)
        dy/dt = -y/tau_psc : 1 (event-driven)
        dz/dt = y/tau_psc - z/tau_rec : 1 (event-driven)
        """,
        on_pre="u += U*(1 - u); share = u*(1 - y - z); y += share",
        parameters={**TSODYKS_MARKRAM, "tau_psc": "5 ms"},
    )
    return law(weight=1.5, delay=1.0)


def pairs(sim: Any, *, own: bool) -> Any:
    if not own:
        return sim.STDPMechanism(
            timing_dependence=sim.SpikePairRule(**numbers(PAIRS)),
            weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=2.0),
            weight=1.0, delay=1.0,
        )  # fmt: skip
    law = sim.EquationSynapse(
        TRACES,
        on_pre="weight = clip(weight - w_max*A_minus*o1, w_min, w_max); r1 += 1",
        on_post="weight = clip(weight + w_max*A_plus*r1, w_min, w_max); o1 += 1",
        parameters={**PAIRS, **LIMITS}, weight_unit="mV",
    )  # fmt: skip
    return law(weight=1.0, delay=1.0)


def triplets(sim: Any, *, own: bool) -> Any:
    if not own:
        return sim.STDPMechanism(
            timing_dependence=sim.PfisterSpikeTripletRule(**numbers(TRIPLETS)),
            weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=2.0),
            weight=1.0, delay=1.0,
        )  # fmt: skip
    law = sim.EquationSynapse(
        TRACES + SLOW,
        on_pre="weight = clip(weight - w_max*o1*(A_minus + A3_minus*r2), w_min, w_max); r1 += 1; r2 += 1",
        on_post="weight = clip(weight + w_max*r1*(A_plus + A3_plus*o2), w_min, w_max); o1 += 1; o2 += 1",
        parameters={**TRIPLETS, **LIMITS}, weight_unit="mV",
    )  # fmt: skip
    return law(weight=1.0, delay=1.0)


TWINS = {"Tsodyks-Markram": tsodyks_markram, "pairs": pairs, "triplets": triplets}


def twin_network(name: str, *, own: bool, on_grid: bool) -> Network:
    """Return 20 sources onto 5 cells, which they or other sources make fire.

    On a grid, the spikes of the 20 sources lie on even steps, and those of the cells on odd ones, since
    simultaneous spikes do not see each other in our own laws, and in equations the target's comes first.
    """
    sim = builder()
    sim.setup(timestep=0.1)
    drawn = np.random.default_rng(4)
    step = 0.2 if on_grid else 1e-3
    even = [np.unique(np.round(drawn.uniform(1.0, 400.0, 25) / step)) * step for _ in range(20)]
    odd = [np.unique(np.round(drawn.uniform(1.0, 400.0, 12) / step)) * step + 0.1 for _ in range(5)]
    sources = sim.Population(20, sim.SpikeSourceArray(spike_times=[list(times) for times in even]))
    drivers = sim.Population(5, sim.SpikeSourceArray(spike_times=[list(times) for times in odd]))
    if name == "Tsodyks-Markram":
        cells = sim.Population(5, sim.IF_curr_exp(tau_syn_E=5.0), label="cells")
    else:
        cells = sim.Population(5, sim.IF_curr_delta(v_thresh=100.0 if on_grid else -50.0), label="cells")
        sim.Projection(drivers, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=500.0, delay=1.0))
    sim.Projection(sources, cells, sim.AllToAllConnector(), TWINS[name](sim, own=own), label="own")
    return sim.network()


def opened(network: Network, options: dict[str, Any]) -> Brain:
    backend = EventBackend()
    return backend.open(network, seed=0, options=backend.options.model_validate(options))


def activity(network: Network, options: dict[str, Any], until_ms: float = 410.0) -> tuple[Any, Any, Any]:
    """Return spikes (time and neuron), voltages and weights at the end."""
    with opened(network, options) as brain:
        heard = brain.add_sink(SpikeRecorder(), network.neurons("cells"), name="spikes")
        brain.run_until(round(until_ms * 1e6))
        spikes = heard.spikes()
        order = np.lexsort((spikes.neurons, spikes.times_ms))
        found = np.stack([spikes.times_ms, spikes.neurons])[:, order]
        return found, brain.read_state("v", network.neurons("cells")), brain.read_weights("own")


@pytest.mark.one_of(6)
@pytest.mark.parametrize("options", MODES, ids=["exact", "grid"])
@pytest.mark.parametrize("name", TWINS)
def test_our_own_laws_as_equations_give_the_same_spikes_and_weights(
    name: str, options: dict[str, Any]
) -> None:
    (mine, v, weights), (theirs, v_theirs, expected) = (
        activity(twin_network(name, own=own, on_grid=bool(options)), options) for own in (True, False)
    )
    assert theirs.shape[1] > 40
    np.testing.assert_allclose(mine, theirs, rtol=1e-12)
    np.testing.assert_allclose(v, v_theirs, rtol=1e-9)
    np.testing.assert_allclose(weights, expected, rtol=1e-12)
    assert (name == "Tsodyks-Markram") == (len(np.unique(expected)) == 1)


TIMES_MS = (10.0, 30.0, 90.0)


def depressing(sim: Any) -> Any:
    return sim.EquationSynapse(
        "dD/dt = (1 - D)/tau_D : 1 (event-driven)",
        on_pre="share = D; D *= depression",
        parameters={"tau_D": "0.3 second", "depression": 0.4}, initial={"D": 1},
    )  # fmt: skip


def tired() -> Network:
    """Return a cell that adds up weights, and a synapse of Abbott's depression (1997, Science 275:220)."""
    sim = builder()
    sim.setup(timestep=0.1)
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=list(TIMES_MS)))
    cell = sim.Population(1, sim.IF_curr_delta(tau_m=1e9, v_rest=0.0, v_reset=0.0, v_thresh=100.0))
    cell.initialize(v=0.0)
    law = depressing(sim)(weight=2.0, delay=1.0, depression=0.5, tau_D=0.1)
    sim.Projection(source, cell, sim.OneToOneConnector(), law)
    return sim.network()


def voltages(network: Network, options: dict[str, Any]) -> list[float]:
    """Return the voltage after each spike; the brain is saved and restored after the first."""
    found = []
    with opened(network, options) as brain:
        brain.run_until(round((TIMES_MS[0] + 2.0) * 1e6))
        found.append(brain.read_state("v", [1])[0])
        saved = brain.snapshot()
        brain.run_until(round(100.0 * 1e6))
        brain.restore(saved)
        for t in TIMES_MS[1:]:
            brain.run_until(round((t + 2.0) * 1e6))
            found.append(brain.read_state("v", [1])[0])
    return found


def formula() -> list[float]:
    total, strength, last, found = 0.0, 1.0, 0.0, []
    for t in TIMES_MS:
        strength = 1.0 - (1.0 - strength) * exp(-(t - last) / 100.0)
        total += 2.0 * strength
        found.append(total)
        strength, last = 0.5 * strength, t
    return found


@pytest.mark.parametrize("options", MODES, ids=["exact", "grid"])
def test_a_law_that_we_do_not_have_is_right_by_its_formula(options: dict[str, Any], tmp_path: Path) -> None:
    network = tired()
    save_network(network, tmp_path / "net.nrpnet")
    assert voltages(read_network(tmp_path / "net.nrpnet"), options) == pytest.approx(formula(), rel=1e-6)


def test_statements_in_another_order_do_not_give_the_formula(monkeypatch: pytest.MonkeyPatch) -> None:
    right = equation_synapses._changed
    monkeypatch.setattr(equation_synapses, "_changed", lambda model, changes: right(model, changes[::-1]))
    assert voltages(tired(), {}) != pytest.approx(formula(), rel=1e-3)


def test_a_rule_that_takes_the_sides_for_each_other_gives_other_weights(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    expected = activity(twin_network("pairs", own=False, on_grid=False), {}, 100.0)[2]
    monkeypatch.setattr(equation_synapses, "TARGET", 0)
    found = activity(twin_network("pairs", own=True, on_grid=False), {}, 100.0)[2]
    assert np.abs(found / expected - 1.0).max() > 1e-3
