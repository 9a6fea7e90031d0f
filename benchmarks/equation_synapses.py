"""The cost of synapses given as equations, against the built-in law with the same equations.

python benchmarks/equation_synapses.py

Both run in turn, in one process; each round is printed with the commit, the load and the cores.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final

from conditions import conditions

from nrp_core.pynn import new_simulator

N_SOURCES, N_CELLS, RATE_HZ, RUN_MS, ROUNDS = 200, 400, 50.0, 1000.0, 5
_TSODYKS_MARKRAM: Final = {"U": 0.2, "tau_rec": 200.0, "tau_facil": 50.0}


def tsodyks_markram(sim: Any, *, own: bool) -> Any:
    """Return the short-term plasticity of Tsodyks, Uziel and Markram, which changes the share of a weight."""
    if not own:
        return sim.TsodyksMarkramSynapse(**_TSODYKS_MARKRAM, weight=0.3, delay=1.0)
    law = sim.EquationSynapse(
        """
        du/dt = -u/tau_facil : 1 (event-driven)
        dy/dt = -y/tau_psc : 1 (event-driven)
        dz/dt = y/tau_psc - z/tau_rec : 1 (event-driven)
        """,
        on_pre="u += U*(1 - u); share = u*(1 - y - z); y += share",
        parameters={"U": "0.2", "tau_rec": "200 ms", "tau_facil": "50 ms", "tau_psc": "5 ms"},
    )
    return law(weight=0.3, delay=1.0)


def pairs(sim: Any, *, own: bool) -> Any:
    """Return plasticity by pairs of spikes, which changes weights."""
    if not own:
        return sim.STDPMechanism(
            timing_dependence=sim.SpikePairRule(
                tau_plus=20.0, tau_minus=20.0, A_plus=0.005, A_minus=0.006
            ),
            weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=0.04),
            weight=0.02, delay=1.0,
        )  # fmt: skip
    law = sim.EquationSynapse(
        """
        dr/dt = -r/tau : 1 (event-driven)
        do/dt = -o/tau : 1 (event-driven)
        """,
        on_pre="weight = clip(weight - w_max*A_minus*o, 0, w_max); r += 1",
        on_post="weight = clip(weight + w_max*A_plus*r, 0, w_max); o += 1",
        parameters={"tau": "20 ms", "A_plus": "0.005", "A_minus": "0.006", "w_max": "0.04"},
    )
    return law(weight=0.02, delay=1.0)


def cost(law: Any, *, own: bool, on_grid: bool) -> tuple[float, int]:
    """Return the CPU time (s) of a run, and the number of spikes of the cells."""
    sim = new_simulator()
    sim.setup(timestep=0.1, seed=3, options={"resolution": "0.1 ms"} if on_grid else {})
    noise = sim.Population(N_SOURCES, sim.SpikeSourcePoisson(rate=RATE_HZ))
    cells = sim.Population(N_CELLS, sim.IF_curr_exp(tau_refrac=2.0, i_offset=0.5))
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.5), law(sim, own=own))
    cells.record("spikes")
    sim.run(1.0)
    began = time.process_time()
    sim.run(RUN_MS)
    taken = time.process_time() - began
    n_spikes = sum(map(len, cells.get_data().segments[0].spiketrains))
    sim.end()
    return taken, n_spikes


def main() -> None:
    """Print all rounds, and the ratio of each pair."""
    print(conditions())
    for law in (tsodyks_markram, pairs):
        for on_grid in (False, True):
            name = f"{law.__name__}, {'grid' if on_grid else 'exact'}"
            print_ratios(name, partial(cost, law, on_grid=on_grid))


def print_ratios(name: str, measure: Callable[..., tuple[float, int]]) -> None:
    """Print rounds in which what is built in and the same as equations run in turn.

    Args:
        name: what is compared.
        measure: returns CPU time (s) and number of spikes, for ``own=False`` and ``own=True``.
    """
    ratios = []
    for k in range(ROUNDS + 1):
        built_in, n_built_in = measure(own=False)
        own, n_own = measure(own=True)
        if k == 0:  # compiles
            continue
        ratios.append(own / built_in)
        print(
            f"{name}: {built_in:.3f} s and {n_built_in} spikes built in, "
            f"{own:.3f} s and {n_own} spikes as equations, ratio {ratios[-1]:.2f}", flush=True,
        )  # fmt: skip
    print(f"{name}: median {statistics.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}")


if __name__ == "__main__":
    main()
