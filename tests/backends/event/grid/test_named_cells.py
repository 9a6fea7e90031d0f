"""Cells in equations with names of their own, against NEST and against SciPy."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nrp_core.pynn as sim

NEST_LATE_MS = 0.1
"""A current of NEST's ``dc_generator`` acts two steps of 0.05 ms late."""
GLIF = {
    1: (50, 6.5, 494.35),
    2: (72, 6.5, 493.35),
    3: (23, 6.5, 496.8),
    4: (22, 6.5, 478.6),
    5: (21, 6.7, 488.75),
}
"""Number, first and last of the spikes of NEST 3.10's ``glif_psc`` with its defaults and steps of 0.05 ms."""


def spikes(
    kind: Any, weight: float, times_ms: list[float], run_ms: float, receptor: str, step_ms: float
) -> Any:
    sim.setup(timestep=step_ms)
    cell = sim.Population(1, kind)
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=times_ms))
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    sim.Projection(source, cell, sim.AllToAllConnector(), synapse, receptor_type=receptor)
    cell.record(["spikes", "v"])
    sim.run(run_ms)
    segment = cell.get_data().segments[0]
    return np.asarray(segment.spiketrains[0]), np.asarray(segment.filter(name="v")[0])[:, 0]


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    "level", [1, 5, *(pytest.param(level, marks=pytest.mark.heavy) for level in (2, 3, 4))]
)
def test_a_generalised_leaky_cell_fires_with_that_of_nest(level: int) -> None:
    kind = getattr(sim, f"GLIF{level}_curr_alpha")(i_offset=0.4)
    found, _ = spikes(kind, 0.3, [100.0, 101.0, 300.0], 500.0, "excitatory", 0.05)
    count, first_ms, last_ms = GLIF[level]
    assert len(found) == count
    assert found[0] == pytest.approx(first_ms - NEST_LATE_MS)
    assert found[-1] == pytest.approx(last_ms, abs=0.4)  # 5 ppm of an interval add up to 72 of them


@pytest.mark.heavy
def test_the_second_excitation_of_an_izhikevich_cell_is_that_of_its_equations() -> None:
    kind = sim.Izhikevich_cond_dual(tau_syn_E2=10.0, e_rev_E=10.0)
    _, v = spikes(kind, 0.05, [4.0], 20.0, "excitatory2", 0.1)

    def rates(_t: float, state: Any) -> list[float]:
        voltage, u, g = state
        current = g * (10.0 - voltage)
        return [
            0.04 * voltage**2 + 5 * voltage + 140 - u + current, 0.02 * (0.2 * voltage - u), -g / 10.0,
        ]  # fmt: skip

    before = solve_ivp(rates, (0.0, 5.0), [-70.0, -14.0, 0.0], rtol=1e-10, atol=1e-10).y[:, -1]
    after = solve_ivp(rates, (5.0, 20.0), [*before[:2], 0.05], rtol=1e-10, atol=1e-10, t_eval=[8.0, 20.0])
    assert v[[50, 80, 200]] == pytest.approx([before[0], *after.y[0]], abs=1e-5)
    assert after.y[0].max() > before[0] + 1.0


FIRST_MS, SECOND_MS = [5.0, 31.0, 100.0, 160.0, 188.0], [10.0, 31.0, 105.0, 130.0, 160.0, 200.0]
"""Arrivals one by one and together; those at 31 and 130 ms come before the second input has decayed to 0."""


def walk_of_motion_detector(n: int, tau_1: float, tau_2: float) -> Any:
    """Return v and the factor by the formulas of ``synapse_types_semd_impl.h`` of sPyNNaker 7.4.1.

    They are walked tick by tick, with the exact course of the leaky membrane in a tick.
    """
    v, first, second, multiplicator, old = -65.0, 0.0, 0.0, 0.0, 0.0
    found = []
    for tick in range(n):
        first += 2.0 * (tick in FIRST_MS)
        second += 3.0 * (tick in SECOND_MS)
        if second >= 0.001 and multiplicator == 0.0 and old == 0.0:
            multiplicator = first
        elif second < 0.001:
            multiplicator = 0.0
        old = second
        found.append((v, multiplicator))
        current, decay, leak = second * multiplicator * 1.5, np.exp(-1.0 / tau_2), np.exp(-1.0 / 20.0)
        v = -65.0 + (v + 65.0) * leak + current * (decay - leak) / (1.0 / 20.0 - 1.0 / tau_2)
        first, second = first * np.exp(-1.0 / tau_1), second * decay
        second = 0.0 if second < 2.0**-15 else second  # the smallest number of the machine
    return np.array(found).T


@pytest.mark.heavy  # compiles for 6 s
def test_a_motion_detector_is_that_of_the_source_of_spynnaker() -> None:
    sim.setup(timestep=1.0)
    kind = sim.IF_curr_exp_sEMD(tau_syn_E=20.0, tau_syn_E2=2.5, scaling_factor=1.5, v_thresh=1e3)
    cell = sim.Population(1, kind)
    for receptor, weight, arrivals in (("excitatory", 2.0, FIRST_MS), ("excitatory2", 3.0, SECOND_MS)):
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[one - 1.0 for one in arrivals]))
        synapse = sim.StaticSynapse(weight=weight, delay=1.0)
        sim.Projection(source, cell, sim.AllToAllConnector(), synapse, receptor_type=receptor)
    cell.record(["multiplicator", "v"])
    sim.run(240.0)
    segment = cell.get_data().segments[0]
    v, multiplicator = (np.asarray(segment.filter(name=name)[0])[:240, 0] for name in ("v", "multiplicator"))
    expected_v, expected = walk_of_motion_detector(240, 20.0, 2.5)
    assert len(set(expected.round(6))) == 5  # it is set to four values, and to 0
    assert multiplicator == pytest.approx(expected, abs=1e-9)
    assert v == pytest.approx(expected_v, abs=1e-3)


@pytest.mark.heavy
def test_a_leaky_cell_adds_two_excitations_of_different_duration() -> None:
    """An exponential current of 1 nA and tau in a leaky cell of 1 nF: a difference of two exponentials."""
    sim.setup(timestep=1.0)
    cell = sim.Population(1, sim.IF_curr_dual_exp(tau_syn_E=2.0, tau_syn_E2=10.0, tau_syn_I=4.0))
    expected, t = -65.0, np.arange(20.0)
    for receptor, weight, tau in (
        ("excitatory", 1.0, 2.0),
        ("excitatory2", 0.5, 10.0),
        ("inhibitory", -0.7, 4.0),
    ):
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[4.0]))
        synapse = sim.StaticSynapse(weight=weight, delay=1.0)
        sim.Projection(source, cell, sim.AllToAllConnector(), synapse, receptor_type=receptor)
        rise = (np.exp(-t / 20.0) - np.exp(-t / tau)) / (1.0 / tau - 1.0 / 20.0)
        expected = expected + weight * rise
    cell.record("v")
    sim.run(25.0)
    v = np.asarray(cell.get_data().segments[0].filter(name="v")[0])[5:25, 0]
    assert v == pytest.approx(expected, abs=1e-6)
