"""A network of benchmarks/networks.py in the event brain: on the grid or exact, or by several threads."""

from __future__ import annotations

import time
from argparse import Namespace
from collections.abc import Sequence
from typing import Any

import measure
import numpy as np
from graphs import Graph, Values

from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.network.data import Network, Population, Projection

_CELLS = {"cuba": "IF_curr_exp", "coba": "IF_cond_exp", "brunel": "IF_curr_delta"}


def network_of(graph: Graph) -> Network:
    """Return the graph as excitatory, inhibitory and Poisson cells; its arrays are shared where possible."""
    cuts = {"exc": slice(0, graph.sizes[0]), "inh": slice(graph.sizes[0], graph.n)}
    populations = {
        label: Population(
            label, cut.stop - cut.start, _CELLS[graph.model],
            {name: np.full(cut.stop - cut.start, value) for name, value in graph.cells.items()},
            {name: values[cut].copy() for name, values in graph.initial.items()},
        )
        for label, cut in cuts.items()
    }  # fmt: skip
    projections = [
        _projection(graph, kind, pre, post, cuts[post]) for kind, pre in enumerate(cuts) for post in cuts
    ]
    rate, weight = graph.noise
    if rate:
        for label, cut in cuts.items():
            n = cut.stop - cut.start
            train = {"rate": np.full(n, rate), "start": np.zeros(n), "duration": np.full(n, 1e10)}
            populations[f"noise_{label}"] = Population(f"noise_{label}", n, "SpikeSourcePoisson", train)
            each = np.arange(n, dtype=np.int32)
            projections.append(
                Projection(
                    f"noise_{label}",
                    f"noise_{label}",
                    label,
                    "excitatory",
                    each,
                    each,
                    np.broadcast_to(weight, n),
                    np.broadcast_to(graph.delay, n),
                )
            )
    return Network(populations, tuple(projections), {}, measure.STEP_MS)


def _projection(graph: Graph, kind: int, pre: str, post: str, targets: slice) -> Projection:
    sources = graph.sources[kind][targets]

    def each(own: Sequence[Values] | None, common: float) -> Values:
        return np.broadcast_to(common, sources.size) if own is None else own[kind][targets].reshape(-1)

    return Projection(
        f"{pre}_{post}", pre, post, ("excitatory", "inhibitory")[kind],
        sources.reshape(-1),  # type: ignore[arg-type]  # taken as they are, and so in less memory
        np.repeat(np.arange(len(sources), dtype=np.uint16), sources.shape[1]),
        each(graph.own_weights, graph.weight[kind]), each(graph.own_delays, graph.delay),
    )  # fmt: skip


def table_bytes(brain: Brain) -> int:
    """Return the size of the tables of synapses."""
    names = ("row_first", "segments", "targets", "weights")
    grid = getattr(brain, "_grid", None)
    return sum(getattr(grid, name).nbytes for name in names) if grid is not None else 0


def opened(network: Network, **options: Any) -> tuple[Brain, Any]:
    """Return an open brain and the recorder of its neurons."""
    backend = brains().load("event")
    brain = backend.open(network, seed=1, options=backend.options.model_validate(options))
    neurons = [network.ids_of(label) for label in ("exc", "inh")]
    return brain, brain.add_sink(SpikeRecorder(), np.concatenate(neurons), name="all")


def run(brain: Brain, duration_ms: float) -> None:
    brain.run_until(brain.now_ns + from_milliseconds(duration_ms))


def alone(chosen: Namespace, network: Network, grid: dict[str, str], n: int, size: int) -> None:
    began = time.process_time()
    brain, recorder = opened(network, **(grid if chosen.mode == "grid" else {}))
    build_s = time.process_time() - began
    run(brain, chosen.warm_up)
    spikes = recorder.spikes()
    costs = measure.chunks(lambda: run(brain, chosen.duration), chosen.chunks, chosen.duration)
    fresh = len(recorder.spikes()) - len(spikes)
    rate = fresh / n / (chosen.duration * chosen.chunks * 1e-3)
    measure.report(
        build_s=build_s, costs=costs, rate_hz=rate, bytes_per_synapse=table_bytes(brain) / size,
        digest=measure.digest(spikes.neurons, spikes.times_ms), synapses=size,
    )  # fmt: skip
    brain.close()


def by_threads(chosen: Namespace, network: Network, grid: dict[str, str]) -> None:
    """Let one thread and several take turns: elapsed time, so the machine must be quiet; the best chunk."""
    pairs = [opened(network, **grid, threads=threads) for threads in (1, chosen.threads)]
    for brain, _ in pairs:
        run(brain, chosen.warm_up)
    turns = np.empty((chosen.chunks, len(pairs)))
    for turn, place in np.ndindex(turns.shape):
        began = time.perf_counter()
        run(pairs[place][0], chosen.duration)
        turns[turn, place] = (time.perf_counter() - began) / chosen.duration * 1e3
    found = [recorder.spikes() for _, recorder in pairs]
    digests = {measure.digest(spikes.neurons, spikes.times_ms) for spikes in found}
    one, several = turns.min(axis=0)
    measure.report(one=one, several=several, same_spikes=len(digests) == 1)
    for brain, _ in pairs:
        brain.close()


def main() -> None:
    chosen = measure.arguments()
    graph = measure.graph_of(chosen)
    network, n, size = network_of(graph), graph.n, graph.size
    del graph
    grid = {"resolution": f"{measure.STEP_MS} ms", "poisson": "grid"}
    if chosen.threads > 1:
        by_threads(chosen, network, grid)
    else:
        alone(chosen, network, grid, n, size)


if __name__ == "__main__":
    main()
