"""The Poisson populations that the grid draws itself, and their tables.

Poisson cells that the grid draws itself: a count for each cell and step, from the exact distribution.

The numbers are a hash of a key, the step and the number of the cell (see
:mod:`nrp_brain_event.random_numbers`), so nothing is stored and any step can be drawn again. Twelve bits
determine most counts by a table; if two counts are possible, 52 more bits are drawn and compared with the
distribution.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, lgamma, log, sqrt
from typing import Final

import numpy as np

from nrp_brain_event.grid.records import Grid, GridClock, Noise
from nrp_brain_event.grid.synapses import store
from nrp_brain_event.grid.tables import common, line_of
from nrp_brain_event.handles import opened
from nrp_brain_event.random_numbers import GOLDEN, mixed
from nrp_brain_event.records import Array
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import inlined, jit
from nrp_core.clock import nanoseconds
from nrp_core.network.data import Network, Projection
from nrp_core.network.drawing import extremes
from nrp_core.network.grid import Grid as TimeGrid
from nrp_core.network.grid import nearest_ns
from nrp_core.network.indices import stored_form
from nrp_core.network.synapses import STATIC

_BITS: Final = 12
N_GUIDE: Final = 1 << _BITS
"""Length of a guide table."""
_PER_WORD: Final = 5
_MASK: Final = np.uint64((1 << _BITS) - 1)
_SHIFT: Final = np.uint64(_BITS)
_REST: Final = np.uint64(64 - _BITS)
_OPEN: Final = -1
"""Entry of a guide table: the first bits do not determine the count."""


def guide(mean: float) -> tuple[Array, Array]:
    """Return the table of a Poisson distribution for the first bits, and its bounds for all 64.

    A count k is drawn by bits u (as a number) with ``bounds[k - 1] <= u < bounds[k]``.
    """
    if mean == 0.0:
        return np.zeros(N_GUIDE, np.int32), np.array([2**64 - 1], np.uint64)
    most = int(mean + 12.0 * sqrt(mean) + 24.0)
    counts = np.arange(most + 1)
    density = np.array([exp(k * log(mean) - mean - lgamma(k + 1)) for k in counts])
    below = np.minimum(np.cumsum(density), 1.0)
    bounds = np.array([min(int(share * 2.0**64), 2**64 - 1) for share in below], np.uint64)
    bounds[-1] = 2**64 - 1
    cells = np.arange(N_GUIDE, dtype=np.uint64) << _REST
    lowest = np.searchsorted(bounds, cells, "right")
    highest = np.searchsorted(bounds, cells + np.uint64((1 << (64 - _BITS)) - 1), "right")
    return np.where(lowest == highest, lowest, _OPEN).astype(np.int32), bounds


def n_words(n_cells: int) -> int:
    """Return the number of random words for the cells of a population in a step."""
    return n_cells // _PER_WORD + 1


def add_noise(places: Array, step: int) -> int:
    """Deliver the spikes that the cells emitted one delay before."""
    grid = opened(Grid, places)
    lines = grid.state.reshape(-1)
    for k in range(len(grid.noise)):
        _add(grid.noise[k], grid, lines, step)
    return 0


def hear_noise(places: Array, step: int) -> int:
    """Store the spikes that recorded cells emit in a step; return 0 if they do not all fit."""
    grid = opened(Grid, places)
    for k in range(len(grid.noise)):
        if grid.noise[k].heard and not _hear(grid.clock[0], grid.noise[k], grid, step):
            return 0
    return 1


@jit
def _add(noise: Noise, grid: Grid, lines: Array, step: int) -> None:
    emitted = step - noise.delay
    if noise.begin < emitted <= noise.end and noise.last > noise.first:
        targets = grid.noise_lines[noise.first : noise.last]
        counts, bounds = grid.noise_guides[noise.guide], grid.noise_bounds[noise.guide]
        place, word = (noise.first - noise.origin) % _PER_WORD, _first_word(noise, emitted)
        if noise.consecutive:
            onto = lines[np.int64(targets[0]) :][: len(targets)]
            _add_counts(onto, targets, counts, bounds, word, place, noise.weight)
        else:
            _scatter_counts(lines, targets, counts, bounds, word, place, noise.weight)


def _adding(line_of: Callable[[Array, int], int]) -> Callable[..., None]:
    """Return the function that delivers counts to the line of each cell."""

    def add(
        lines: Array, targets: Array, counts: Array, bounds: Array, number: np.uint64, place: int,
        weight: float,
    ) -> None:  # fmt: skip
        """Deliver counts; the first one is at a place in the word with a number."""
        begun = min((_PER_WORD - place) % _PER_WORD, len(targets))
        if begun > 0:
            word = mixed(number)
            number += GOLDEN
            for i in range(begun):
                lines[line_of(targets, i)] += weight * _count(counts, bounds, word, place + i)
        whole = len(targets) - (len(targets) - begun) % _PER_WORD
        for first in range(begun, whole, _PER_WORD):
            word = mixed(number)
            number += GOLDEN
            for j in range(_PER_WORD):  # a constant, so that it is unrolled
                lines[line_of(targets, first + j)] += weight * _count(counts, bounds, word, j)
        word = mixed(number)
        for i in range(whole, len(targets)):
            lines[line_of(targets, i)] += weight * _count(counts, bounds, word, i - whole)

    return jit(add)


@inlined
def _its_own(targets: Array, i: int) -> int:  # noqa: ARG001
    return i


@inlined
def _listed(targets: Array, i: int) -> int:
    line: int = targets[i]
    return line


_add_counts, _scatter_counts = _adding(_its_own), _adding(_listed)


@jit
def _hear(clock: GridClock, noise: Noise, grid: Grid, step: int) -> bool:
    if not noise.begin < step <= noise.end:
        return True
    counts, bounds = grid.noise_guides[noise.guide], grid.noise_bounds[noise.guide]
    number, place = _first_word(noise, step), (noise.first - noise.origin) % _PER_WORD
    for first in range(noise.first - place, noise.last, _PER_WORD):
        word = mixed(number)
        number += GOLDEN
        for i in range(max(first, noise.first), min(first + _PER_WORD, noise.last)):
            count = _count(counts, bounds, word, i - first)
            if clock.n_spikes + count > len(grid.spikes):
                return False
            for _ in range(count):
                store(clock, grid, grid.noise_ids[i], step)
    return True


@jit
def _first_word(noise: Noise, step: int) -> np.uint64:
    """Return the number of the first word of a step; the words of all steps differ."""
    words = step * noise.n_words + (noise.first - noise.origin) // _PER_WORD
    return np.uint64(noise.key) + np.uint64(words) * GOLDEN


@jit
def _count(counts: Array, bounds: Array, word: np.uint64, j: int) -> int:
    """Return the count of a word for its j-th cell."""
    high = (word >> np.uint64(j * _BITS)) & _MASK
    count = counts[high]
    return _decide(bounds, high, word, j) if count == _OPEN else count


@jit
def _decide(bounds: Array, high: np.uint64, word: np.uint64, j: int) -> int:
    """Return the count if the first bits do not determine it."""
    low = mixed(~word + np.uint64(j) * GOLDEN)
    u = (high << _REST) | (low >> _SHIFT)
    count = 0
    while u >= bounds[count] and count < len(bounds) - 1:
        count += 1
    return count


def drawable(network: Network) -> frozenset[str]:
    """Return the labels of the Poisson populations of equal cells with one synapse each.

    All of the synapses of a projection have the same weight and delay, so that the input is a count; onto an
    assembly there are several projections.
    """
    return frozenset(
        label for label, population in network.populations.items()
        if population.cell_type == "SpikeSourcePoisson" and population.size
        and all(common(values) is not None for values in population.parameters.values())
        and _is_private(population.size, [p for p in network.projections if p.pre == label])
    )  # fmt: skip


def _is_private(size: int, projections: list[Projection]) -> bool:
    if sum(projection.size for projection in projections) != size:
        return False
    alike = all(
        projection.synapse_type == STATIC
        and projection.size
        and common(extremes(stored_form(projection, name))) is not None
        for projection in projections
        for name in ("weight", "delay_ms")
    )
    if not alike:
        return False
    sources = np.concatenate([projection.pre_index for projection in projections])
    return np.array_equal(np.sort(sources), np.arange(size))


def load_noise(
    network: Network, cells: Array, row_of: IntArray, times: TimeGrid, drawn: frozenset[str]
) -> dict[str, Array]:
    """Return the parts of the :class:`~nrp_brain_event.grid.records.Grid` that hold noise, by name."""
    labels = (label for label in network.populations if label in drawn)
    projections = [part for label in labels for part in network.projections if part.pre == label]
    noise = np.zeros(len(projections), Noise.dtype())
    guides: list[tuple[Array, Array]] = []
    lines, sources = [np.empty(0, np.uint32)], [np.empty(0, np.int32)]
    first, origins = 0, dict[str, int]()
    for record, projection in zip(noise, projections, strict=True):
        population = network.populations[projection.pre]
        rate, start, duration = (float(population.parameters[n][0]) for n in ("rate", "start", "duration"))
        post = row_of[network.offsets[projection.post] + projection.post_index.astype(np.int64)]
        line = line_of(
            cells[post[0]], network.populations[projection.post].receptor_number(projection.receptor)
        )
        flat, ids = (
            line * len(cells) + post,
            network.offsets[projection.pre] + projection.pre_index.astype(np.int64),
        )
        order = np.argsort(flat, kind="stable")
        lines.append(flat[order].astype(np.uint32))
        sources.append(ids[order].astype(np.int32))
        # the projections of a population share its random words, one after the other
        record["origin"] = origins.setdefault(projection.pre, first)
        record["n_words"] = n_words(population.size)
        record["first"], record["last"] = first, first + projection.size
        record["consecutive"] = (np.diff(lines[-1].astype(np.int64)) == 1).all()
        record["guide"], record["weight"] = len(guides), projection.weight[0]
        record["delay"] = times.delays(projection.delay_ms[:1])[0]
        start_ns, duration_ns = nanoseconds([start, duration]).tolist()
        record["begin"], record["end"] = (
            nearest_ns(t_ns, times.step_ns) // times.step_ns for t_ns in (start_ns, start_ns + duration_ns)
        )
        guides.append(guide(rate * times.step_ms * 1e-3))
        first += projection.size
    widest = max((len(bounds) for _, bounds in guides), default=1)
    noise_bounds = np.full((len(guides), widest), 2**64 - 1, np.uint64)
    for own, (_, bounds) in zip(noise_bounds, guides, strict=True):
        own[: len(bounds)] = bounds
    return {
        "noise": noise,
        "noise_lines": np.concatenate(lines),
        "noise_ids": np.concatenate(sources),
        "noise_guides": np.array([counts for counts, _ in guides], np.int32).reshape(len(guides), N_GUIDE),
        "noise_bounds": noise_bounds,
    }
