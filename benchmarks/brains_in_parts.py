"""A network of a million plastic synapses in the exact mode of ``event``, whole and in two parts.

Two halves of balanced spiking cells, each with synapses onto itself and onto the other half, all excitatory
ones with STDP. The whole runs in this process; of the two parts each runs in a process of its own. They take
turns and simulate the same windows. Seconds per simulated second, elapsed and of CPU time: of the thread of
the loop, then of each process of a part. The thread waits while parts run, so two free cores need at most its
time and that of the slower part together. On a busy machine the best window shows most.

    python benchmarks/brains_in_parts.py
    python benchmarks/brains_in_parts.py --cells 400 --rounds 2
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from conditions import load, print_conditions

from nrp_core import brains
from nrp_core.brain import Brain, Network, RemoteBrain, SpikeRecorder
from nrp_core.brain.remote.process import activity
from nrp_core.clock import NS_PER_MS
from nrp_core.network.pynn import builder
from nrp_core.network.pynn.export import network_of

WINDOW_MS = 20
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def network(cells: int, fan_in: int, delay_ms: float) -> Network:
    """Return two halves of cells that fire by themselves, with ``fan_in`` synapses onto each cell.

    Nine in ten synapses are excitatory and plastic; half of the synapses come from the other half.
    """
    sim = builder(1)
    sim.setup(timestep=0.1)
    rng = np.random.default_rng(1)
    halves = []
    for label in ("left", "right"):
        half = sim.Population(
            cells // 2, sim.IF_curr_exp(tau_m=20.0, tau_syn_E=5.0, tau_syn_I=5.0), label=label
        )
        half.set(i_offset=rng.uniform(0.6, 0.9, half.size))
        half.initialize(v=rng.uniform(-65.0, -50.0, half.size))
        halves.append(half)
    stdp = {
        "timing_dependence": sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.01, A_minus=0.012),
        "weight_dependence": sim.AdditiveWeightDependence(w_min=0.0, w_max=0.002),
    }
    for pre in halves:
        for post in halves:
            for share, receptor in ((0.9, "excitatory"), (0.1, "inhibitory")):
                connector = sim.FixedNumberPreConnector(round(share * fan_in / 2))
                if receptor == "excitatory":
                    synapse = sim.STDPMechanism(**stdp, weight=0.001, delay=delay_ms)
                else:
                    synapse = sim.StaticSynapse(weight=-0.009, delay=delay_ms)
                label = f"{pre.label} to {post.label}, {receptor}"
                sim.Projection(pre, post, connector, synapse, receptor_type=receptor, label=label)
    return network_of(sim.state, {})


def cpu_s(brain: Any) -> Iterator[float]:
    """Yield the CPU seconds used by this thread, and by the processes of the parts of a brain."""
    yield time.thread_time()
    for part in getattr(brain, "_brains", ()):
        if isinstance(part, RemoteBrain):
            yield activity(part._process.pid)[0] / TICKS_PER_S


def advance(brain: Brain) -> tuple[float, list[float]]:
    """Run a window; return the elapsed time and the CPU time of each process, s."""
    before, began = list(cpu_s(brain)), time.perf_counter()
    brain.run_until(brain.now_ns + WINDOW_MS * NS_PER_MS)
    elapsed_s = time.perf_counter() - began
    return elapsed_s, [after - since for after, since in zip(cpu_s(brain), before, strict=True)]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cells", type=int, default=4000)
    parser.add_argument("--fan-in", type=int, default=250)
    parser.add_argument("--delay", type=float, default=1.5, help="of all synapses, ms")
    parser.add_argument("--rounds", type=int, default=10, help="windows of 20 ms after the first five")
    arguments = parser.parse_args()
    print_conditions()
    whole = network(arguments.cells, arguments.fan_in, arguments.delay)
    print(f"{whole.size} cells, {sum(one.size for one in whole.projections)} synapses")
    apart = {"parts": {name: {"populations": [name], "process": True} for name in ("left", "right")}}
    opened, recorders = {}, {}
    for name, backend, options in (("whole", "event", {}), ("two parts", "composite", apart)):
        found = brains().load(backend)
        opened[name] = found.open(whole, seed=1, options=found.options.model_validate(options))
        recorders[name] = opened[name].add_sink(SpikeRecorder(), np.arange(whole.size), name="all")
    elapsed: dict[str, list[float]] = {name: [] for name in opened}
    used: dict[str, list[list[float]]] = {name: [] for name in opened}
    for number in range(5 + arguments.rounds):
        for name, brain in opened.items():
            elapsed_s, each_s = advance(brain)
            if number >= 5:
                elapsed[name].append(elapsed_s)
                used[name].append(each_s)
    trains = [recorders[name].spikes() for name in opened]  # type: ignore[attr-defined]
    assert trains[0].times_ms.tolist() == trains[1].times_ms.tolist(), "the parts are not the whole"
    windows_s = arguments.rounds * WINDOW_MS / 1000
    rate_hz = len(trains[0]) / whole.size / (opened["whole"].now_ns / 1e9)
    print(f"{rate_hz:.1f} spikes/s and cell; {load()}")
    for name, brain in opened.items():
        each = ", ".join(f"{one / windows_s:.2f}" for one in np.sum(used[name], axis=0))
        best = min(elapsed[name]) * 1000 / WINDOW_MS
        total = sum(elapsed[name]) / windows_s
        print(f"{name:10} elapsed {total:6.2f} s/s (best window {best:6.2f}), CPU: {each} s/s")
        brain.close()


if __name__ == "__main__":
    main()
