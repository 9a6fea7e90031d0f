"""The extra cost of a step if the brain runs in a process of its own, by the number of input events.

Two brains of 100 silent cells, one here and one in another process, take turns and get the same events. Wall
time, the best of many steps: the cost of the round trip matters, not the load of the machine.

    python benchmarks/process_host.py --events 0 80 4000 100000
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np
from conditions import print_conditions
from nrp_brain_event import EventBackend

from nrp_core.brain.interface import Brain
from nrp_core.brain.remote import RemoteBrain
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.network.pynn import builder
from nrp_core.network.pynn.export import network_of

CELLS = 100
STEP_MS = 20
WEIGHT_NA = 1e-6


def step_s(brain: Brain, rng: np.random.Generator, n_events: int) -> float:
    """Return the wall time of a step with this number of events."""
    times_ms = milliseconds(brain.now_ns) + STEP_MS * rng.random(n_events)
    events = SynapticEvents(rng.integers(0, CELLS, n_events), times_ms, np.full(n_events, WEIGHT_NA))
    began = time.perf_counter()
    if n_events:
        brain._do_inject(events)
    brain.run_until(brain.now_ns + STEP_MS * NS_PER_MS)
    return time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--events", nargs="+", type=int, default=[0, 80, 4000, 100_000])
    parser.add_argument("--steps", type=int, default=400)
    arguments = parser.parse_args()
    print_conditions()
    sim = builder(1)
    sim.setup(timestep=0.1)
    sim.Population(CELLS, sim.IF_curr_exp(), label="cells")
    network, backend = network_of(sim.state, {}), EventBackend()
    options = backend.options()
    for n_events in arguments.events:
        rng = np.random.default_rng(1)
        costs_s: tuple[list[float], list[float]] = ([], [])
        with (
            backend.open(network, seed=1, options=options) as here,
            RemoteBrain(backend, network, seed=1, options=options, python=sys.executable) as there,
        ):
            for _ in range(max(20, arguments.steps // (1 + n_events // 1000))):
                for brain, costs in zip((here, there), costs_s, strict=True):
                    costs.append(step_s(brain, rng, n_events))
        own, remote = (min(costs) * 1e6 for costs in costs_s)
        print(f"{n_events:7d} events: {own:8.1f} us here, {remote:8.1f} us there, {remote - own:+.1f} us")


if __name__ == "__main__":
    main()
