"""Elapsed time of a balanced network on NEURON in one process and in several, by its number of cells.

The best of some windows of 20 ms counts, and seconds are per simulated second. The
processes need free cores.

    python benchmarks/processes.py --cells 100 400 1600 --processes 1 2
"""

from __future__ import annotations

import argparse
import os
import time

from nrp_core.brain import Brain, Network, builder, network_of
from nrp_core.clock import NS_PER_MS

from nrp_brain_pynn import PyNNBackend

FAN_IN = 50
WINDOW_MS = 20


def network(cells: int) -> Network:
    """Return cells that fire by themselves, with 50 synapses onto each and delays of 1.5 ms."""
    sim = builder(1)
    sim.setup(timestep=0.1)
    population = sim.Population(cells, sim.IF_curr_alpha(i_offset=0.8), label="cells")
    for weight, share, receptor in ((0.01, 0.8, "excitatory"), (-0.05, 0.2, "inhibitory")):
        synapse = sim.StaticSynapse(weight=weight, delay=1.5)
        connector = sim.FixedNumberPreConnector(round(share * FAN_IN))
        sim.Projection(population, population, connector, synapse, receptor_type=receptor, label=receptor)
    return network_of(sim.state, {})


def window_s(brain: Brain) -> float:
    began = time.perf_counter()
    brain.run_until(brain.now_ns + WINDOW_MS * NS_PER_MS)
    return time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cells", nargs="+", type=int, default=[100, 400, 1600])
    parser.add_argument("--processes", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--windows", type=int, default=20)
    arguments = parser.parse_args()
    backend = PyNNBackend()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    for cells in arguments.cells:
        whole, best = network(cells), []
        for processes in arguments.processes:
            options = backend.options(processes=processes)
            with backend.open(whole, seed=1, options=options) as brain:
                windows_s = [window_s(brain) for _ in range(3 + arguments.windows)][3:]
            best.append(min(windows_s) * 1000 / WINDOW_MS)
        figures = ", ".join(f"{n}: {s:.2f} s/s" for n, s in zip(arguments.processes, best, strict=True))
        print(f"{cells} cells, by processes: {figures}", flush=True)


if __name__ == "__main__":
    main()
