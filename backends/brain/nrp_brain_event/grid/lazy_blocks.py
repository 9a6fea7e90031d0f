"""Cells with linear equations on the lazy grid.

Spikes arrive where they do in the plain grid, and a cell on which one acts is put into the list of its
block. Once in a step a kernel takes each cell of the list to the present step and lets it fire. The cell
stays in the list while it is refractory or may reach the threshold without further input.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from nrp_brain_event.grid.equations.blocks import owners_of, parameters_of
from nrp_brain_event.grid.equations.layout import kept, length_of_row, values_of
from nrp_brain_event.grid.equations.lazy_source import factors_of_kind, lazy_kernel, n_inputs, width_of
from nrp_brain_event.grid.lazy_neuron import IN_LIST, LOOK, NONE, Lazy, LazyBlock
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import call, opened
from nrp_brain_event.options import combinations
from nrp_brain_event.records import Array
from nrp_core._support.arrays import aligned_copy
from nrp_core._support.jit import inlined
from nrp_core.network.data import Network

_S_PER_MS: Final = 1e-3
_LOOKS: Final = 3
"""The cost of looking at a cell, relative to that of a built-in one."""
_length_of_row = inlined(length_of_row)


def load_lazy_blocks(grid: Grid, network: Network) -> dict[str, Array]:
    """Return the arrays of the lazy grid for cells with equations, which go on where a grid is."""
    states, factors = [np.empty(0)], [np.empty(0)]
    step_s = float(grid.clock["h"][0]) * _S_PER_MS
    blocks = np.zeros(len(grid.blocks), LazyBlock.dtype())
    owners = np.full(len(grid.drive), NONE, np.int32)
    every = zip(blocks, grid.blocks, owners_of(network), strict=True)
    for number, (own, block, (population, cell)) in enumerate(every):
        n, model = population.size, cell.model
        known = parameters_of(grid, block, n, model)
        chosen, kind_of = combinations(known, n)
        kinds = [
            factors_of_kind(model, {name: row[[k]] for name, row in known.items()}, step_s) for k in chosen
        ]
        places = np.cumsum([sum(map(len, factors)), *map(len, kinds)])
        own["code"], own["state"] = lazy_kernel(model, equal=len(kinds) == 1), sum(map(len, states))
        own["first"], own["width"] = block["first"], width_of(model)
        owners[block["first"] : block["last"]] = number
        rows = grid.values[block["value"] :][: len(values_of(model)) * length_of_row(n)]
        cells = np.zeros((n, width_of(model)))
        begin, end = n_inputs(model), n_inputs(model) + len(kept(model))
        cells[:, begin:end] = rows.reshape(len(values_of(model)), -1)[: end - begin, :n].T
        cells[:, end], cells[:, end + 1] = grid.clock["step"][0], places[kind_of]
        states.append(cells.ravel())
        factors += kinds
    return {
        "blocks": blocks,
        "owners": owners,
        "listed": np.arange(len(grid.drive), dtype=np.int32),
        "states": aligned_copy(np.concatenate(states)),
        "factors": np.concatenate(factors),
        "shown": np.zeros(1, np.int32),
    }


def n_kinds_of_blocks(grid: Grid, network: Network) -> int:
    """Return how many combinations of parameters cells with equations have."""
    return sum(
        len(combinations(parameters_of(grid, block, population.size, cell.model), population.size)[0])
        for block, (population, cell) in zip(grid.blocks, owners_of(network), strict=True)
    )


def look_at_blocks(places: Array, own: Array, step: int) -> int:
    """Advance the cells in the lists and let them fire; drop those that cannot reach the threshold."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    clock = grid.clock[0]
    for number in range(len(lazy.blocks)):
        block = lazy.blocks[number]
        if block.n_listed == 0:
            continue
        lazy.clock[0].n_checked += _LOOKS * block.n_listed
        n_fired = _advanced(grid, lazy, number, lazy.listed, block.first, block.n_listed, step, LOOK)
        if n_fired < 0:
            clock.failed = grid.ids[block.first - 1 - n_fired]
            return 0
        clock.n_fired = n_fired
        _drop(block, lazy)
    return 0


def advance_row(places: Array, own: Array, row: int, step: int, purpose: int) -> int:
    """Advance a cell with equations, for a purpose of :mod:`nrp_brain_event.grid.equations.lazy_source`."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    lazy.shown[0] = row
    owner = lazy.owners[row]
    number = owner if owner >= 0 else owner + IN_LIST
    return _advanced(grid, lazy, number, lazy.shown, 0, 1, step, purpose)


@inlined
def _drop(block: LazyBlock, lazy: Lazy) -> None:
    """Remove the rows that are marked from a list."""
    kept_ = 0
    for k in range(block.first, block.first + block.n_listed):
        row = lazy.listed[k]
        if row < 0:
            lazy.owners[-1 - row] += IN_LIST
        else:
            lazy.listed[block.first + kept_] = row
            kept_ += 1
    block.n_listed = kept_


@inlined
def _advanced(
    grid: Grid, lazy: Lazy, number: int, rows: Array, begin: int, n_due: int, step: int, purpose: int
) -> int:
    clock, block, own = grid.clock[0], grid.blocks[number], lazy.blocks[number]
    n = block.last - block.first
    n_fired: int = call(
        own.code,
        (
            grid.values, grid.constants, grid.state, grid.drive, grid.fired, lazy.states, lazy.factors, rows,
            block.value, block.constant, own.state, _length_of_row(n), block.first, n, len(grid.drive), begin,
            n_due, clock.n_fired, step, clock.h * _S_PER_MS, purpose,
        ),
    )  # fmt: skip
    return n_fired
