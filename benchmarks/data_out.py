"""The cost of recorded data: state variables during a run, and spikes after it.

python benchmarks/data_out.py
"""

from __future__ import annotations

import time
from typing import Any

from conditions import print_conditions

from nrp_core.pynn import new_simulator

N_CELLS, RUN_MS = 1000, 1000.0
N_SOURCES, RATE_HZ = 140_000, 71.5
"""About a million spikes in 100 ms."""


def run_cost(variables: list[str]) -> float:
    """Return the CPU time (s) of a run of 1000 cells at 0.1 ms, in which variables are recorded."""
    sim = new_simulator()
    sim.setup(timestep=0.1, options={"resolution": "0.1 ms"})
    cells = sim.Population(N_CELLS, sim.IF_curr_exp(i_offset=0.9))
    noise = sim.Population(N_CELLS, sim.SpikeSourcePoisson(rate=100.0))
    sim.Projection(noise, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.1, delay=1.0))
    sim.Projection(
        cells, cells, sim.FixedProbabilityConnector(0.1), sim.StaticSynapse(weight=0.001, delay=1.5)
    )
    cells.record(variables)
    sim.run(10.0)
    began = time.process_time()
    sim.run(RUN_MS)
    return time.process_time() - began


def many_spikes() -> tuple[Any, float]:
    """Return the spike trains of 140 000 cells, and the CPU time (s) of ``get_data``."""
    sim = new_simulator()
    sim.setup(timestep=0.1, options={"resolution": "0.1 ms"})
    cells = sim.Population(N_SOURCES, sim.SpikeSourcePoisson(rate=RATE_HZ))
    cells.record("spikes")
    sim.run(100.0)
    began = time.process_time()
    trains = cells.get_data().segments[0].spiketrains
    return trains, time.process_time() - began


def main() -> None:
    """Print all figures."""
    print_conditions()
    run_cost([])  # compiles
    for name, variables in (("nothing", []), ("v", ["v"])):
        rounds = [run_cost(variables) for _ in range(3)]
        print(f"run that records {name}: {min(rounds):.3f} s of {', '.join(f'{one:.3f}' for one in rounds)}")
    trains, cost_s = many_spikes()
    print(f"get_data of {len(trains)} cells, {len(trains.multiplexed[0])} spikes: {cost_s:.2f} s")
    began = time.process_time()
    for _ in trains:
        pass
    print(f"one object for each of these trains: {time.process_time() - began:.1f} s")


if __name__ == "__main__":
    main()
