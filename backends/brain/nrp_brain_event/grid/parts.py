"""A grid that several threads advance, each a part of its rows.

Until the end of a window (see :mod:`nrp_brain_event.grid.advance`) parts do not affect each other, so locks
are not needed. Every part has the calendar of the whole grid, with the segments reduced to its own targets:
inputs arrive at a row in the same order for any number of parts.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from nrp_brain_event.grid.advance import run
from nrp_brain_event.grid.inputs import arrange
from nrp_brain_event.grid.loader import enlarged, with_runs
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import Handle, handle
from nrp_brain_event.records import DONE, FULL, Array
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import COMPILED, jit

Held = Handle[Grid]
_run = run
if not COMPILED:  # NumPy would warn of overflowing hashes, and of the NaN voltage of refractory cells
    _run = np.errstate(over="ignore", invalid="ignore")(run)


def advance(held: Held, until: int) -> tuple[Held, int]:
    """Advance a grid, or a part of one, to a step; return it, and ``DONE`` or ``DIVERGED``."""
    while (status := _run(held.places, until)) == FULL:
        held = handle(enlarged(held.arrays))
    return held, status


class Share(NamedTuple):
    """A part: its rows, and its share of segments and Poisson cells."""

    first: int
    last: int
    segments: Array
    noise_first: IntArray
    noise_last: IntArray


class Threads:
    """Advances a grid with bit for bit the result of :func:`advance`.

    Args:
        n: number of threads, at most one for each row.
        n_rows: number of rows of the grid.
    """

    def __init__(self, n: int, n_rows: int) -> None:
        self._bounds = [n_rows * k // n for k in range(n + 1)]
        self._pool = ThreadPoolExecutor(n - 1, "nrp-event")
        self._shares: list[Share] = []
        self._targets: Array | None = None
        """Names of the shared tables."""

    def advance(self, held: Held, until: int) -> tuple[Held, int]:
        """Advance a grid to a step; return it, and ``DONE`` or ``DIVERGED``."""
        grid = _with_cuts(held.arrays, self._bounds[:-1])
        arrange(grid.clock[0], grid.sources, grid.arrivals)
        if self._targets is not grid.targets:
            self._shares = [_share(grid, *rows) for rows in zip(self._bounds, self._bounds[1:], strict=False)]
            self._targets = grid.targets
        parts, status = [handle(_part(grid, share)) for share in self._shares], DONE
        window, step = int(grid.clock["window"][0]), int(grid.clock["step"][0])
        while step < until and status == DONE:
            if step % window == 0:
                parts = _exchanged(parts)
            step = min(until, step - step % window + window)
            others = [self._pool.submit(advance, part, step) for part in parts[1:]]
            done = [advance(parts[0], step), *(other.result() for other in others)]
            parts, status = [part for part, _ in done], max(status for _, status in done)
        return handle(_joined(grid, [part.arrays for part in parts])), status

    def close(self) -> None:
        """Stop the threads."""
        self._pool.shutdown()


def _with_cuts(grid: Grid, rows: list[int]) -> Grid:
    """Return the grid with its runs split at these rows."""
    firsts = np.union1d(grid.runs["first"], rows)
    if len(firsts) == len(grid.runs):
        return grid
    runs = grid.runs[np.searchsorted(grid.runs["first"], firsts, "right") - 1]
    runs["first"], runs["last"] = firsts, np.append(firsts[1:], len(grid.drive))
    runs["head"] = runs["n_waiting"] = 0
    return with_runs(grid, runs)


def _share(grid: Grid, first: int, last: int) -> Share:
    segments = grid.segments.copy()
    _cut_segments(grid, first, last, segments)
    noise = [grid.noise_lines[own["first"] : own["last"]] for own in grid.noise]
    rows = [lines % len(grid.drive) for lines in noise]
    bounds = [
        np.searchsorted(own, [first, last]) for own in rows
    ]  # ascending, because all act on one variable
    noise_first, noise_last = (np.reshape(bounds, (-1, 2)).astype(np.int64) + grid.noise["first"][:, None]).T
    return Share(first, last, segments, noise_first, noise_last)


@jit
def _cut_segments(grid: Grid, first: int, last: int, segments: Array) -> None:
    """Reduce segments to the targets ``first <= row < last``."""
    for k in range(len(segments)):
        segment = segments[k]
        end = segment.start + segment.length
        row = grid.tables[segment.table].line % len(grid.drive)
        segment.start = _first_from(grid.targets, segment.start, end, first - row)
        segment.length = _first_from(grid.targets, segment.start, end, last - row) - segment.start


@jit
def _first_from(targets: Array, a: int, b: int, lowest: int) -> int:
    """Return the index of the first of ascending targets that is not below a row."""
    while a < b:
        middle = (a + b) // 2
        if targets[middle] < lowest:
            a = middle + 1
        else:
            b = middle
    return a


def _part(grid: Grid, share: Share) -> Grid:
    """Return a part of a grid; the first part has the clock, calendar and spikes of the whole."""
    runs = slice(*np.searchsorted(grid.runs["first"], [share.first, share.last]))
    noise = grid.noise.copy()
    noise["first"], noise["last"] = share.noise_first, share.noise_last
    part = grid._replace(
        runs=grid.runs[runs], noise=noise, fired=grid.fired[share.first : share.last],
        probes=grid.probes.copy(),
        segments=share.segments,
    )  # fmt: skip
    if share.first == 0:
        return part
    clock = grid.clock.copy()
    clock["n_spikes"] = clock["n_out"] = 0
    return part._replace(
        clock=clock, work=grid.work.copy(), scratch=np.empty_like(grid.scratch), slots=grid.slots.copy(),
        entry_segment=grid.entry_segment.copy(), entry_after=grid.entry_after.copy(),
        outbox=np.zeros_like(grid.outbox), spikes=np.zeros_like(grid.spikes),
    )  # fmt: skip


def _exchanged(parts: list[Held]) -> list[Held]:
    """Return the parts, each with the spikes of all parts to send."""
    waiting = _waiting([part.arrays for part in parts])
    exchanged = [(part, _with_waiting(part.arrays, waiting)) for part in parts]
    return [part if arrays is part.arrays else handle(arrays) for part, arrays in exchanged]


def _waiting(parts: list[Grid]) -> IntArray:
    """Return the spikes of all parts to send, in the order of the whole grid."""
    waiting = np.concatenate([part.outbox[:, : part.clock["n_out"][0]] for part in parts], axis=1)
    key = waiting[0] * len(parts[0].drive) + waiting[1]
    return waiting.take(np.argsort(key, kind="stable"), axis=1)


def _with_waiting(part: Grid, waiting: IntArray) -> Grid:
    n = waiting.shape[1]
    while part.outbox.shape[1] < n:
        part = enlarged(part)
    part.outbox[:, :n] = waiting
    part.clock["n_out"] = n
    return part


def _joined(grid: Grid, parts: list[Grid]) -> Grid:
    """Return the whole grid from its parts."""
    first = _with_waiting(parts[0], _waiting(parts))
    failed = [part.clock for part in reversed(parts) if part.clock["failed"][0] >= 0]
    if failed:  # the whole grid stops in the first step in which a neuron fails, and reports the last one
        first.clock["failed"] = min(failed, key=lambda clock: int(clock["step"][0]))["failed"]
    spikes = np.concatenate([part.spikes[: part.clock["n_spikes"][0]] for part in parts])
    while len(first.spikes) < len(spikes):
        first = enlarged(first)
    first.spikes[: len(spikes)] = spikes
    first.clock["n_spikes"] = len(spikes)
    return grid._replace(
        slots=first.slots, entry_segment=first.entry_segment, entry_after=first.entry_after,
        outbox=first.outbox, spikes=first.spikes, probes=first.probes,
    )  # fmt: skip
