"""A synthetic twin of the fly's brain (FlyWire v783) on one core: lazy grid, plain grid, Brian2 in C++.

138 639 cells of Shiu et al. (2024) and 15.1 million synapses with log-normal degrees; the cells with most
synapses are driven at 150 Hz. All get the same graph and input and take turns. CPU seconds per simulated
second without building and compiling; every round is shown. Brian2 runs with the interpreter that is given;
without one it is left out.

    python benchmarks/connectome.py
    python benchmarks/connectome.py --brian2 brian2-venv/bin/python --rounds 3
    python benchmarks/connectome.py --growth --plot growth.png
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from conditions import conditions, load

from nrp_core import Network, Population, Projection, brains, read_network, save_network
from nrp_core.brain import SpikeRecorder

N, N_SYNAPSES = 138_639, 15_091_983
LIF = {
    "v_rest": -52.0, "v_reset": -52.0, "v_thresh": -45.0, "tau_m": 20.0, "cm": 0.02, "tau_refrac": 2.2,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0, "i_offset": 0.0,
}  # fmt: skip
DRIVEN, GROWTH_MS = (10, 30, 60, 120, 240), 500.0
UNIT_MV, KICK_MV, DELAY_MS, STEP_MS, RATE_HZ = 0.275, 20_000.0, 1.8, 0.1, 150.0
PEER = Path(__file__).parent / "peers" / "connectome_brian2.py"
Edges = tuple[npt.NDArray[np.int32], npt.NDArray[np.int32], npt.NDArray[np.float64]]


def edges(n_synapses: int = N_SYNAPSES, seed: int = 783) -> Edges:
    """Return source, target and weight (mV) of each synapse, by source; a third of the cells inhibit."""
    rng = np.random.default_rng(seed)
    shares = [rng.lognormal(0.0, 0.9, N) for _ in range(2)]
    pre, post = (rng.choice(N, n_synapses, p=share / share.sum()).astype(np.int32) for share in shares)
    pre.sort()
    sign = np.where(rng.random(N) < 0.35, -1.0, 1.0)
    return pre, post, sign[pre] * UNIT_MV * rng.geometric(0.28, n_synapses)


def hubs(pre: npt.NDArray[np.int32], n: int) -> npt.NDArray[np.int64]:
    """Return the cells with the most synapses, ascending."""
    return np.sort(np.argsort(np.bincount(pre, minlength=N), kind="stable")[-n:])


def kicks(n: int, duration_ms: float) -> list[npt.NDArray[np.int64]]:
    """Return the steps at which each driven cell is made to fire."""
    rng = np.random.default_rng(1)
    n_steps = round(duration_ms / STEP_MS) - 1
    return [np.flatnonzero(rng.random(n_steps) < RATE_HZ * STEP_MS * 1e-3) + 1 for _ in range(n)]


def network(synapses: Edges, driven: npt.NDArray[np.int64], trains: list[npt.NDArray[np.int64]]) -> Network:
    """Return the brain and its input."""
    pre, post, weight = synapses
    full = {name: np.full(N, value) for name, value in LIF.items()}
    refractory = np.full(N, LIF["tau_refrac"])
    refractory[driven] = 0.0
    brain = Population(
        "brain", N, "IF_curr_exp_frozen", full | {"tau_refrac": refractory}, {"v": full["v_rest"]}
    )
    given = tuple(steps.astype(np.float64) * STEP_MS for steps in trains)
    source = Population("kicks", len(driven), "SpikeSourceArray", {}, spike_times_ms=given)
    each, hit = np.arange(len(driven), dtype=np.int32), driven.astype(np.int32)
    weights, delays = (np.full(len(driven), value) for value in (KICK_MV, STEP_MS))
    projections = [Projection("kick", "kicks", "brain", "excitatory", each, hit, weights, delays)]
    for receptor, mine in (("excitatory", weight > 0), ("inhibitory", weight < 0)):
        delay = np.broadcast_to(np.float64(DELAY_MS), int(mine.sum()))
        part = pre[mine], post[mine], weight[mine], delay
        projections.append(Projection(receptor, "brain", "brain", receptor, *part))
    return Network({"brain": brain, "kicks": source}, tuple(projections))


class Cost(NamedTuple):
    """The cost of a run.

    Args:
        opening_s: CPU s from the network as data to the first step.
        spent: CPU s of a simulated second.
        n_spikes: number of spikes.
        events_m: million synaptic events in a simulated second.
    """

    opening_s: float
    spent: float
    n_spikes: int
    events_m: float

    def __str__(self) -> str:
        return (
            f"{self.spent:.3f} CPU s/s   {self.n_spikes} spikes   {self.events_m:.1f} M events/s   "
            f"opened in {self.opening_s:.1f} CPU s"
        )


def cost(made: Network, lazy: str, duration_ms: float, out_degree: npt.NDArray[np.int64]) -> Cost:
    """Run a network on one of the grids."""
    event = brains().load("event")
    options = event.options.model_validate({"resolution": "0.1 ms", "lazy": lazy})
    began = time.process_time()
    with event.open(made, seed=1, options=options) as brain:
        recorder = brain.add_sink(SpikeRecorder(), made.neurons("brain"), name="all")
        brain.run_until(1_000_000)
        opened = time.process_time()
        brain.run_until(round(duration_ms * 1e6))
        spent = (time.process_time() - opened) / (duration_ms - 1.0) * 1e3
        found = recorder.spikes()  # type: ignore[attr-defined]
    events_m = float(out_degree[found.neurons].sum()) / duration_ms * 1e-3
    return Cost(opened - began, spent, len(found.neurons), events_m)


def peer(python: str, arrays: dict[str, npt.NDArray[Any]], duration_ms: float) -> str:
    """Return what Brian2 needs, as text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "graph.npz")
        np.savez(path, allow_pickle=False, **arrays)
        done = subprocess.run(
            [python, str(PEER), str(path), str(duration_ms)], capture_output=True, text=True, check=True
        )
    return done.stdout.strip().splitlines()[-1]


def building(synapses: Edges) -> Iterator[str]:
    """Yield how long it takes from the edges, and from a file, to the first step."""
    driven = hubs(synapses[0], 10)
    began = time.process_time()
    made = network(synapses, driven, kicks(10, 10.0))
    spent = time.process_time() - began
    yield f"edges to network: {spent:.1f} CPU s; {cost(made, 'auto', 2.0, np.zeros(N, int))}"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "brain.nrpnet")
        began = time.process_time()
        save_network(made, path)
        yield f"written: {time.process_time() - began:.1f} CPU s, {path.stat().st_size / 1e6:.0f} MB"
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
            yield fresh.submit(from_file, path).result()


def from_file(path: Path) -> str:
    """Return the cost of reading a network and of its first steps, and the peak memory of this process."""
    began = time.process_time()
    made = read_network(path)
    spent = time.process_time() - began
    first = cost(made, "auto", 2.0, np.zeros(N, int))
    return f"read: {spent:.1f} CPU s; {first}; peak memory {peak_mb():.0f} MB"


def peak_mb() -> float:
    """Return the largest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


class Growth(NamedTuple):
    """The cost with a number of synapses and of driven cells; the memory includes the tables of the graph."""

    synapses: int
    driven: int
    cost: Cost
    memory_mb: float


def grown(n_synapses: int, n_driven: int) -> Growth:
    """Build a network, run it, and return its cost; called in a process of its own, for its peak memory."""
    synapses = edges(n_synapses)
    made = network(synapses, hubs(synapses[0], n_driven), kicks(n_driven, GROWTH_MS))
    out_degree = np.bincount(synapses[0], minlength=N + n_driven)
    del synapses
    return Growth(n_synapses, n_driven, cost(made, "auto", GROWTH_MS, out_degree), peak_mb())


def growth(plot: Path | None) -> None:
    """Print the cost of fewer synapses with 60 driven cells, and of all with more or fewer driven cells."""
    print("synapses (M)  driven  events/s (M)  to the first step (CPU s)  CPU s/s  peak memory (MB)")
    rows = []
    for case in [(N_SYNAPSES // 4, 60), (N_SYNAPSES // 2, 60), *((N_SYNAPSES, n) for n in DRIVEN)]:
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
            one = fresh.submit(grown, *case).result()
        rows.append(one)
        numbers = f"{one.synapses / 1e6:12.1f}  {one.driven:6}  {one.cost.events_m:12.2f}"
        costs = f"{one.cost.opening_s:25.1f}  {one.cost.spent:7.3f}  {one.memory_mb:16.0f}"
        print(f"{numbers}  {costs}", flush=True)
    if plot is not None:
        draw(rows, plot)


def draw(rows: Sequence[Growth], path: Path) -> None:
    """Draw the cost over the events, and time and memory over the synapses."""
    from matplotlib.figure import Figure

    by_events = [(one.cost.events_m, one.cost.spent) for one in rows if one.synapses == N_SYNAPSES]
    alike = [one for one in rows if one.driven == 60]
    opening = [(one.synapses / 1e6, one.cost.opening_s) for one in alike]
    memory = [(one.synapses / 1e6, one.memory_mb) for one in alike]
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    for axes, points, x, y in zip(
        figure.subplots(1, 3), (by_events, opening, memory),
        ("million events in a simulated second", *["million synapses"] * 2),
        ("CPU s for it", "CPU s to the first step", "peak memory (MB)"), strict=True,
    ):  # fmt: skip
        axes.plot(*zip(*points, strict=True), "o-")
        axes.set(xlabel=x, ylabel=y, xlim=(0, None), ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--brian2", metavar="PYTHON", help="interpreter that has Brian2")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--duration", type=float, default=1000.0, help="ms")
    parser.add_argument("--driven", type=int, nargs="+", default=[30, 120], help="numbers of driven cells")
    parser.add_argument("--growth", action="store_true", help="costs over synapses and events alone")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="with --growth: draw a figure")
    given = parser.parse_args()
    print(conditions())
    if given.growth:
        growth(given.plot)
        print(load())
        return
    synapses = edges()
    for line in building(synapses):
        print(line, flush=True)
    out_degree = np.bincount(synapses[0], minlength=N + max(given.driven))
    for n in given.driven:
        driven, trains = hubs(synapses[0], n), kicks(n, given.duration)
        made = network(synapses, driven, trains)
        for number in range(given.rounds):
            for lazy in ("auto", "never"):
                print(f"{n} driven, lazy {lazy}: {cost(made, lazy, given.duration, out_degree)}", flush=True)
            if given.brian2:
                source = np.repeat(driven, [len(own) for own in trains])
                arrays: dict[str, npt.NDArray[Any]] = dict(
                    zip(("pre", "post", "weight"), synapses, strict=True)
                )
                arrays |= {"driven": driven, "cells": source, "steps": np.concatenate(trains)}
                print(f"{n} driven, Brian2: {peer(given.brian2, arrays, given.duration)}", flush=True)
            elif number == 0:
                print("Brian2 is left out: give an interpreter with --brian2")
    print(f"peak memory with the tables of the graph {peak_mb():.0f} MB, {load()}")


if __name__ == "__main__":
    main()
