"""A network of benchmarks/networks.py on the grid of the event brain, by one thread and by several in turn.

Elapsed time instead of CPU time, so the machine must be quiet; the best of all chunks.
"""

from __future__ import annotations

import time

import measure
import numpy as np
from nrp_run import network_of

from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds


def elapsed(brain: Brain, duration_ms: float) -> float:
    """Return seconds per simulated second of a run."""
    began = time.perf_counter()
    brain.run_until(brain.now_ns + from_milliseconds(duration_ms))
    return (time.perf_counter() - began) / duration_ms * 1e3


def main() -> None:
    chosen = measure.arguments()
    graph = measure.graph_of(chosen)
    network, n = network_of(graph), graph.n
    del graph
    backend = brains().load("event")
    grid = {"resolution": f"{measure.STEP_MS} ms", "poisson": "grid"}
    opened, recorders = [], []
    for threads in (1, chosen.threads):
        options = backend.options.model_validate({**grid, "threads": threads})
        opened.append(backend.open(network, seed=1, options=options))
        recorders.append(opened[-1].add_sink(SpikeRecorder(), np.arange(n), name="all"))
        opened[-1].run_until(from_milliseconds(chosen.warm_up))
    turns = [[elapsed(brain, chosen.duration) for brain in opened] for _ in range(chosen.chunks)]
    found = [recorder.spikes() for recorder in recorders]  # type: ignore[attr-defined]
    digests = {measure.digest(spikes.neurons, spikes.times_ms) for spikes in found}
    one, several = np.min(turns, axis=0)
    measure.report(one=one, several=several, same_spikes=len(digests) == 1)
    for brain in opened:
        brain.close()


if __name__ == "__main__":
    main()
