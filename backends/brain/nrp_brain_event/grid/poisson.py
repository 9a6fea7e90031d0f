"""The Poisson populations that the grid draws itself, and their tables."""

from __future__ import annotations

import numpy as np

from nrp_brain_event.grid.noise import N_GUIDE, guide, n_words
from nrp_brain_event.grid.records import Noise
from nrp_brain_event.grid.runs import line_of
from nrp_brain_event.grid.tables import common
from nrp_brain_event.records import Array
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.network.drawing import extremes
from nrp_core.brain.network.grid import Grid as TimeGrid
from nrp_core.brain.network.indices import stored_form
from nrp_core.brain.network.synapses import STATIC

_NEVER = 1 << 62


def drawable(network: Network) -> frozenset[str]:
    """Return the labels of the Poisson populations of equal cells with one synapse each.

    All of the synapses have the same weight and delay, so that the input is a count.
    """
    return frozenset(
        label for label, population in network.populations.items()
        if population.cell_type == "SpikeSourcePoisson" and population.size
        and all(common(values) is not None for values in population.parameters.values())
        and _is_private(population.size, [p for p in network.projections if p.pre == label])
    )  # fmt: skip


def _is_private(size: int, projections: list[Projection]) -> bool:
    if len(projections) != 1 or projections[0].synapse_type != STATIC or not projections[0].size:
        return False
    (projection,) = projections
    alike = all(
        common(extremes(stored_form(projection, name))) is not None for name in ("weight", "delay_ms")
    )
    return alike and np.array_equal(np.sort(projection.pre_index), np.arange(size))


def load_noise(
    network: Network, cells: Array, row_of: IntArray, times: TimeGrid, drawn: frozenset[str]
) -> dict[str, Array]:
    """Return the parts of the :class:`~nrp_brain_event.grid.records.Grid` that hold noise, by name."""
    projections = [projection for projection in network.projections if projection.pre in drawn]
    noise = np.zeros(len(projections), Noise.dtype())
    guides: list[tuple[Array, Array]] = []
    lines, sources = [np.empty(0, np.uint32)], [np.empty(0, np.int32)]
    first = 0
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
        record["origin"], record["n_words"] = first, n_words(projection.size)
        record["first"], record["last"] = first, first + projection.size
        record["consecutive"] = (np.diff(lines[-1].astype(np.int64)) == 1).all()
        record["guide"], record["weight"] = len(guides), projection.weight[0]
        record["delay"] = times.delays(projection.delay_ms[:1])[0]
        record["begin"] = min(round(start / times.step_ms), _NEVER)
        record["end"] = min(round(min((start + duration) / times.step_ms, 2.0**61)), _NEVER)
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
