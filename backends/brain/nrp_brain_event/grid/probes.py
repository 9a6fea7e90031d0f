"""State variables that are recorded while the grid runs, inside compiled code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_brain_event.grid.equations.blocks import places_of
from nrp_brain_event.grid.readout import reading_of, sampled
from nrp_brain_event.grid.records import Grid, Probe
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import Trace
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.grid import Grid as TimeGrid

_NONE = {
    "probes": np.empty(0, Probe.dtype()), "probe_steps": np.empty(0, np.int64),
    "probe_rows": np.empty(0, np.int64), "probe_values": np.empty((2, 0)), "probe_rest": np.empty((2, 0)),
    "samples": np.empty(0),
}  # fmt: skip


def no_probes() -> dict[str, Array]:
    """Return the arrays of a grid that records nothing."""
    return dict(_NONE)


def load_probes(
    grid: Grid,
    network: Network,
    traces: Sequence[Trace],
    samples: FloatArray,
    row_of: IntArray,
    times: TimeGrid,
) -> dict[str, Array]:
    """Return the arrays of a grid that stores the samples of traces, one trace after another."""
    probes = np.zeros(len(traces), Probe.dtype())
    places = [places_of(grid, network, row_of[trace.neurons], trace.variable) for trace in traces]
    probes["variable"] = [
        reading_of(trace.variable) if (own < 0).any() else -1
        for trace, (own, _) in zip(traces, places, strict=True)
    ]
    shapes = np.array([trace.shape for trace in traces])
    probes["n_steps"], probes["n_rows"] = shapes.T
    for name, sizes in (("step", shapes[:, 0]), ("row", shapes[:, 1]), ("sample", shapes.prod(axis=1))):
        probes[name] = np.cumsum(sizes) - sizes
    rows = row_of[np.concatenate([trace.neurons for trace in traces])]
    probes["plain"] = [
        trace.variable == "v" and (own < 0).all() and _are_plain(grid, row_of[trace.neurons])
        for trace, (own, _) in zip(traces, places, strict=True)
    ]
    runs = grid.runs[np.searchsorted(grid.runs["first"], rows, "right") - 1]
    return {
        "probes": probes,
        "probe_steps": np.concatenate([trace.times_ns for trace in traces]) // times.step_ns,
        "probe_rows": rows,
        "probe_values": np.concatenate([np.stack(both).astype(float) for both in places], axis=1),
        "probe_rest": np.stack([runs["v_rest"], runs["v_rest"] + runs["reset"]]),
        "samples": samples,
    }


def _are_plain(grid: Grid, rows: IntArray) -> bool:
    """Return whether rows follow each other, and all of their neurons advance in a loop."""
    return bool((np.diff(rows) == 1).all() and (grid.cell_rows[rows] < 0).all())


def take_samples(places: Array, step: int) -> int:
    """Take the samples that are due at a step, of the rows of this part."""
    grid = opened(Grid, places)
    for k in range(len(grid.probes)):
        probe = grid.probes[k]
        if probe.taken < probe.n_steps and grid.probe_steps[probe.step + probe.taken] == step:
            sampled(grid, probe, step)
            probe.taken += 1
    return 0
