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


@pytest.mark.parametrize("level", GLIF)
def test_a_generalised_leaky_cell_fires_with_that_of_nest(level: int) -> None:
    kind = getattr(sim, f"GLIF{level}_curr_alpha")(i_offset=0.4)
    found, _ = spikes(kind, 0.3, [100.0, 101.0, 300.0], 500.0, "excitatory", 0.05)
    count, first_ms, last_ms = GLIF[level]
    assert len(found) == count
    assert found[0] == pytest.approx(first_ms - NEST_LATE_MS)
    assert found[-1] == pytest.approx(last_ms, abs=0.4)  # 5 ppm of an interval add up to 72 of them


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
