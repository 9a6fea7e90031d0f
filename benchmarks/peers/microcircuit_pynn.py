"""The cortical microcircuit of Potjans and Diesmann (2014) as a PyNN script.

    python benchmarks/peers/microcircuit_pynn.py --scale 0.1
    python benchmarks/peers/microcircuit_pynn.py --simulator pyNN.nest --scale 0.05

The whole network (``--scale 1``) has 77 169 cells and 299 million synapses, each with a weight and a delay
of its own. The last line is a report in JSON.
"""

from __future__ import annotations

import argparse
import importlib
import json
import resource
import time
from types import ModuleType
from typing import Any

import microcircuit_model as model
import numpy as np


def build(sim: ModuleType, scale: float, **options: Any) -> dict[str, Any]:
    """Build the network; return its populations by label."""
    sim.setup(timestep=model.STEP_MS, **options)
    populations = {}
    currents, rates = model.constant_na(scale), model.input_hz(scale)
    for k, label in enumerate(model.LABELS):
        size = int(model.sizes(scale)[k])
        cells = sim.Population(size, sim.IF_curr_exp(**model.CELL, i_offset=currents[k]), label=label)
        mean, deviation = model.START_MV
        cells.initialize(v=sim.RandomDistribution("normal", mu=mean, sigma=deviation))
        cells[: model.OBSERVED].record("spikes")
        populations[label] = cells
        source = sim.Population(size, sim.SpikeSourcePoisson(rate=rates[k]), label=f"input {label}")
        weight = model.WEIGHT_NA / np.sqrt(scale)
        synapse = sim.StaticSynapse(weight=weight, delay=model.DELAY_MS["E"])
        sim.Projection(source, cells, sim.OneToOneConnector(), synapse, receptor_type="excitatory")
    for target, source in np.argwhere(model.PROBABILITIES > 0):
        _connect(sim, populations, int(target), int(source), scale)
    return populations


def _connect(sim: ModuleType, populations: dict[str, Any], target: int, source: int, scale: float) -> None:
    kind = model.LABELS[source][-1]
    mean = model.weights_na(scale)[target, source]
    low, high = (0.0, np.inf) if kind == "E" else (-np.inf, 0.0)
    deviation = abs(mean) * model.spread(target, source)
    weight = sim.RandomDistribution("normal_clipped", mu=mean, sigma=deviation, low=low, high=high)
    mean = model.DELAY_MS[kind]
    deviation = mean * model.DELAY_SPREAD
    delay = sim.RandomDistribution("normal_clipped", mu=mean, sigma=deviation, low=model.STEP_MS, high=np.inf)
    sim.Projection(
        populations[model.LABELS[source]],
        populations[model.LABELS[target]],
        sim.FixedTotalNumberConnector(int(model.synapses(scale)[target, source])),
        sim.StaticSynapse(weight=weight, delay=delay),
        receptor_type="excitatory" if kind == "E" else "inhibitory",
    )


def measured(
    sim: ModuleType, scale: float, warm_up_ms: float, duration_ms: float, **options: Any
) -> dict[str, Any]:
    """Build and run the network; return its costs and statistics."""
    began, first = time.process_time(), time.perf_counter()
    populations = build(sim, scale, **options)
    built = time.process_time()
    sim.run(warm_up_ms)
    ready, elapsed = time.process_time(), time.perf_counter() - first
    at = time.perf_counter()
    sim.run(duration_ms)
    cost, run_elapsed = time.process_time() - ready, time.perf_counter() - at
    found = {}
    for label, cells in populations.items():
        trains = cells[: model.OBSERVED].get_data("spikes").segments[0].spiketrains
        times = [np.asarray(train.magnitude) for train in trains]
        found[label] = model.statistics(times, warm_up_ms, warm_up_ms + duration_ms)
    return {
        "scale": scale,
        "synapses": int(model.synapses(scale).sum()),
        "build_cpu_s": built - began,
        "to_start_cpu_s": ready - began,
        "to_start_s": elapsed,
        "s_per_s": cost / duration_ms * 1e3,
        "elapsed_s_per_s": run_elapsed / duration_ms * 1e3,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "statistics": found,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--simulator", default="nrp_core.pynn")
    parser.add_argument("--scale", type=float, default=0.1)
    parser.add_argument("--warm-up", type=float, default=100.0, help="ms")
    parser.add_argument("--duration", type=float, default=1000.0, help="ms")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    options: dict[str, Any] = {"threads": asked.threads}
    if asked.simulator == "nrp_core.pynn":
        own = {"resolution": "0.1 ms", "poisson": "grid", "threads": asked.threads}
        options = {"backend": "event", "options": own, "seed": asked.seed}
    sim = importlib.import_module(asked.simulator)
    found = measured(sim, asked.scale, asked.warm_up, asked.duration, **options)
    print(model.table(found["statistics"], asked.scale))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
