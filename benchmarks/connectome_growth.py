"""How the cost of a brain of a fly's size grows with its synapses and with the events that they carry.

The twin of connectome.py, on its lazy grid and one core: first with fewer synapses and 60 driven cells, then
with all of them and more or fewer driven cells. Every row has a process of its own, for its peak memory.

    python benchmarks/connectome_growth.py --plot growth.png
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from conditions import conditions, load
from connectome import N_SYNAPSES, RATE_HZ, N, edges, hubs, kicks, network, peak_mb

from nrp_core import brains
from nrp_core.brain import SpikeRecorder

SYNAPSES = (N_SYNAPSES // 4, N_SYNAPSES // 2, N_SYNAPSES)
DRIVEN = (10, 30, 60, 120, 240)
DURATION_MS, BEGIN_NS = 500.0, 1_000_000


class Cost(NamedTuple):
    """The cost of one network with one input.

    Args:
        synapses: their number.
        driven: number of driven cells.
        events_hz: synaptic events in a simulated second.
        opening_s: CPU s from the network as data to the first step.
        spent: CPU s of a simulated second.
        memory_mb: peak memory of the process, with the tables from which the network was made.
    """

    synapses: int
    driven: int
    events_hz: float
    opening_s: float
    spent: float
    memory_mb: float


def measured(n_synapses: int, n_driven: int) -> Cost:
    """Build a network, run it, and return its cost."""
    synapses = edges(n_synapses)
    cells = hubs(synapses[0], n_driven)
    made = network(synapses, cells, kicks(n_driven, DURATION_MS))
    out_degree = np.bincount(synapses[0], minlength=N + n_driven)
    del synapses
    event = brains().load("event")
    options = event.options.model_validate({"resolution": "0.1 ms", "lazy": "auto"})
    began = time.process_time()
    with event.open(made, seed=1, options=options) as brain:
        recorder = brain.add_sink(SpikeRecorder(), made.neurons("brain"), name="all")
        brain.run_until(BEGIN_NS)
        opened = time.process_time()
        brain.run_until(round(DURATION_MS * 1e6))
        spent = (time.process_time() - opened) / (DURATION_MS * 1e-3 - BEGIN_NS * 1e-9)
        found = recorder.spikes()  # type: ignore[attr-defined]
    events_hz = float(out_degree[found.neurons].sum()) / DURATION_MS * 1e3
    return Cost(n_synapses, n_driven, events_hz, opened - began, spent, peak_mb())


def draw(by_synapses: Sequence[Cost], by_events: Sequence[Cost], path: Path) -> None:
    """Draw the cost over the events, and time and memory over the synapses."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    events, opening, memory = figure.subplots(1, 3)
    for axes, rows, x, y, labels in (
        (events, by_events, "events_hz", "spent", ("million events in a simulated second", "CPU s for it")),
        (opening, by_synapses, "synapses", "opening_s", ("million synapses", "CPU s to the first step")),
        (memory, by_synapses, "synapses", "memory_mb", ("million synapses", "peak memory (MB)")),
    ):
        axes.plot([getattr(one, x) / 1e6 for one in rows], [getattr(one, y) for one in rows], "o-")
        axes.set(xlabel=labels[0], ylabel=labels[1], xlim=(0, None), ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw a figure")
    given = parser.parse_args()
    print(f"{conditions()}; {RATE_HZ:g} Hz each driven cell", flush=True)
    print("synapses (M)  driven  events/s (M)  to the first step (CPU s)  CPU s/s  peak memory (MB)")
    rows = []
    for case in [*((n, 60) for n in SYNAPSES[:-1]), *((N_SYNAPSES, n) for n in DRIVEN)]:
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
            one = fresh.submit(measured, *case).result()
        rows.append(one)
        numbers = f"{one.synapses / 1e6:12.1f}  {one.driven:6}  {one.events_hz / 1e6:12.2f}"
        costs = f"{one.opening_s:25.1f}  {one.spent:7.3f}  {one.memory_mb:16.0f}"
        print(f"{numbers}  {costs}", flush=True)
    if given.plot is not None:
        whole = [one for one in rows if one.synapses == N_SYNAPSES]
        draw([*rows[: len(SYNAPSES) - 1], *(one for one in whole if one.driven == 60)], whole, given.plot)
    print(load())


if __name__ == "__main__":
    main()
