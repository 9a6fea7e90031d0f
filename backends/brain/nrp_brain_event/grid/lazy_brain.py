"""A network on the lazy grid.

Builds the lazy grid from a grid at any step, and the reverse.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import e, exp
from typing import Any, Final

import numpy as np

from nrp_brain_event.cell_types import TIME_CONSTANTS
from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.brain import GridBrain
from nrp_brain_event.grid.equations.blocks import require_input
from nrp_brain_event.grid.lazy_advance import run
from nrp_brain_event.grid.lazy_blocks import load_lazy_blocks, n_kinds_of_blocks
from nrp_brain_event.grid.lazy_neuron import (
    CHANGING,
    DEPTH,
    KEPT,
    LEAK,
    N_COURSE,
    NONE,
    S_EFFECT,
    SECOND,
    X_EFFECT,
    Kind,
    Lazy,
    LazyClock,
    Neuron,
    enlisted,
    set_currents,
    show_all,
    watch,
)
from nrp_brain_event.grid.loader import enlarged, offsets_of
from nrp_brain_event.grid.on_demand import with_kernels
from nrp_brain_event.grid.records import ADVANCE_ROW, EQUATIONS, JUMP, LOOK_AT_BLOCKS, Grid
from nrp_brain_event.handles import Handle, handle, opened
from nrp_brain_event.options import MOST_KINDS
from nrp_brain_event.records import FULL, Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import COMPILED, jit
from nrp_core.errors import CapabilityError
from nrp_core.network.changes import ParameterChange
from nrp_core.network.filters import driven

_DECIDING: Final = ("kind", "alpha", "frozen", "refractory", "v_rest", "reset", "threshold")
_CONSTANTS: Final = ("tau_m", "cm")
_LONG: Final = 80.0
"""Time constants after which nothing remains."""
_SAFETY: Final = 1.001
"""The peaks are looked for at many times, not at all."""
Kinds = tuple[Array, Array, FloatArray]


def load_kinds(grid: Grid, cells: Array) -> Kinds:
    """Return the ``Kind`` records, the kind of each row, and the courses of all kinds.

    Args:
        grid: the grid.
        cells: the ``Cell`` in each row, for its time constants.
    """
    runs, first = grid.runs, cells[grid.runs["first"]]
    chosen, kind_of_run = kinds_of(grid, cells)
    kinds = np.zeros(max(len(chosen), 1), Kind.dtype())
    courses = np.zeros((len(chosen) * DEPTH, N_COURSE))
    h = float(grid.clock["h"][0])
    for number, (kind, row) in enumerate(zip(kinds, chosen.tolist(), strict=False)):
        kind["course"] = number * DEPTH
        _fill(kind, runs[row], first[row], h, courses[number * DEPTH : (number + 1) * DEPTH])
    return kinds, np.repeat(kind_of_run, runs["last"] - runs["first"]), courses


def kinds_of(grid: Grid, cells: Array) -> tuple[IntArray, IntArray]:
    """Return the first run of each kind, and the kind of each run; those with equations have none."""
    own = np.flatnonzero(grid.runs["kind"] != EQUATIONS)
    runs, first = grid.runs[own], cells[grid.runs["first"][own]]
    columns = [runs[name].astype(float) for name in _DECIDING] + [first[name] for name in _CONSTANTS]
    deciding = np.column_stack([*columns, first["tau_syn"]])
    _, chosen, kinds = np.unique(deciding, axis=0, return_index=True, return_inverse=True)
    kind_of_run = np.zeros(len(grid.runs), np.int64)
    kind_of_run[own] = kinds.reshape(-1)
    return own[chosen], kind_of_run


def from_plain(grid: Grid, kinds: Kinds, of_blocks: Mapping[str, Array]) -> Lazy:
    """Return the lazy grid that continues from the state of a plain grid.

    Args:
        grid: the grid.
        kinds: its :func:`load_kinds`.
        of_blocks: its :func:`~nrp_brain_event.grid.lazy_blocks.load_lazy_blocks`.
    """
    records, kind_of, courses = kinds
    n_rows, step = len(kind_of), int(grid.clock["step"][0])
    waiting, single = np.isnan(grid.state[grid_records.V]), records["single"][kind_of] == 1
    neurons = np.zeros(n_rows, Neuron.dtype())
    neurons["v"] = np.where(waiting, records["reset"][kind_of], grid.state[grid_records.V])
    neurons["step"], neurons["kind"] = step, kind_of
    neurons["free"] = np.where(waiting, grid.release - 1, step - 1)
    for name, line in (("x", grid_records.X), ("s", grid_records.S)):
        both = grid.state[line : line + 2]
        neurons[name][:, 0] = np.where(single, both.sum(axis=0), both[0])
        neurons[name][:, 1] = np.where(single, 0.0, both[1])
    clock = np.zeros(1, LazyClock.dtype())
    clock["driven"] = (grid.drive != 0.0).any()
    rows = np.zeros((2, n_rows), np.int32)
    lazy = Lazy(clock, records, neurons, courses, rows[0], rows[1], **of_blocks)
    _watch_all(handle(grid).places, handle(lazy).places)
    return lazy


def to_plain(grid: Grid, lazy: Lazy) -> Grid:
    """Return the plain grid that continues from the state of a lazy grid."""
    grid = grid._replace(
        state=grid.state.copy(), runs=grid.runs.copy(), queue=grid.queue.copy(), release=grid.release.copy(),
        values=grid.values.copy(),
    )  # fmt: skip
    show_all(handle(grid).places, handle(lazy).places, np.arange(len(lazy.neurons)))
    waiting = np.isnan(grid.state[grid_records.V])
    grid.release[:] = lazy.neurons["free"] + 1
    grid.runs["head"] = grid.runs["n_waiting"] = 0
    rows = np.flatnonzero(waiting)
    rows = rows[np.argsort(grid.release[rows], kind="stable")]
    of = np.searchsorted(grid.runs["first"], rows, "right") - 1
    for place in np.unique(of):
        mine = rows[of == place]
        grid.queue[grid.runs["first"][place] :][: len(mine)] = mine
        grid.runs["n_waiting"][place] = len(mine)
    return grid


def changing(lazy: Lazy) -> dict[str, Array]:
    """Return copies of all arrays that change while running, by name."""
    return {name: getattr(lazy, name).copy() for name in CHANGING}


def _fill(kind: Any, run: Any, cell: Any, h: float, courses: FloatArray) -> None:
    for name in ("alpha", "frozen", "refractory", "reset", "threshold", "grown"):
        kind[name] = run[name]
    kind["jump"], kind["resistance"] = run["kind"] == JUMP, cell["tau_m"] / cell["cm"]
    tau_m, taus = float(cell["tau_m"]), cell["tau_syn"].tolist()
    kind["single"] = kind["jump"] or taus[0] == taus[1]
    kind["simple"] = kind["single"] and not (kind["jump"] or kind["alpha"])
    unit = tau_m if kind["frozen"] else float(cell["cm"])
    steps = np.arange(DEPTH)
    courses[:, LEAK] = np.exp(-steps * h / tau_m)
    if kind["jump"]:
        kind["x_peak"] = 1.0
        return
    for k, tau in enumerate(taus):
        courses[:, KEPT + k * SECOND] = np.exp(-steps * h / tau)
        every = np.unique(np.geomspace(1.0, max(_LONG * max(tau_m, tau) / h, 2.0), 4 * DEPTH).astype(int))
        for column, x, s in ((X_EFFECT, 1.0, 0.0), (S_EFFECT, 0.0, e / tau)):
            effect = [_effect(n * h, tau_m, tau, x, s) / unit for n in steps.tolist()]
            courses[:, column + k * SECOND] = effect
            peak = max(_effect(n * h, tau_m, tau, x, s) / unit for n in every.tolist()) * _SAFETY
            kind["x_peak" if x else "s_peak"][k] = peak


def _effect(t: float, tau_m: float, tau: float, x: float, s: float) -> float:
    return driven(t, exp(-t / tau_m), exp(-t / tau), 1.0 / tau - 1.0 / tau_m, x, s)


@jit
def _watch_all(places: Array, own: Array) -> None:
    grid, lazy = opened(grid_records.Grid, places), opened(Lazy, own)
    for row in range(len(lazy.neurons)):
        if lazy.owners[row] != NONE:
            enlisted(lazy, row)
        else:
            neuron = lazy.neurons[row]
            watch(lazy, neuron, lazy.kinds[neuron.kind], row, grid.drive[row])


_PLAIN_STEP_NS: Final = 0.6
_PLAIN_ARRIVAL_NS: Final = 1.0
_LAZY_STEP_NS: Final = 8.0
_LAZY_ARRIVAL_NS: Final = 8.0
"""Cost of a step of a neuron, and of an arrival, on both grids."""
_PATIENCE: Final = 5
"""Number of judgements in succession after which the plain grid takes over."""
_run = run if COMPILED else np.errstate(over="ignore", invalid="ignore")(run)


class LazyBrain(GridBrain):
    """See :class:`~nrp_core.brain.interface.Brain`.

    It continues as a plain grid where events are frequent enough to make this cheaper. It decides by counts,
    at certain steps, so a run is the same however it is divided.
    """

    _lazy: Handle[Lazy] | None = None
    """None where the plain grid has taken over."""

    def _step_to(self, step: int) -> int:
        if self._lazy is None:
            return super()._step_to(step)
        places = self._lazy.places
        while (status := _run(self._held.places, places, step)) == FULL:
            self._take(handle(enlarged(self._grid)))
        if step % self._patience == 0:
            self._judge(self._lazy.arrays)
        return int(status)

    def _judge(self, lazy: Lazy) -> None:
        """Continue as a plain grid where this has been cheaper for some time."""
        clock, n_rows = lazy.clock[0], len(lazy.neurons)
        plain = _PLAIN_STEP_NS * n_rows * self._patience + _PLAIN_ARRIVAL_NS * clock["n_arrived"]
        own = _LAZY_STEP_NS * clock["n_checked"] + _LAZY_ARRIVAL_NS * clock["n_arrived"]
        clock["costly"] = clock["costly"] + 1 if own > plain else 0
        clock["n_arrived"] = clock["n_checked"] = 0
        if clock["costly"] >= _PATIENCE and self._options.lazy != "always":
            self._leave()

    def _leave(self) -> None:
        """Continue as a plain grid."""
        if self._lazy is not None:
            self._take(handle(to_plain(self._grid, self._lazy.arrays)))
            self._lazy = None

    def _enter(self) -> None:
        """Continue as a lazy grid."""
        own = self._of_blocks()
        self._lazy = handle(from_plain(self._grid, load_kinds(self._grid, self._cells), own))

    def _of_blocks(self) -> dict[str, Array]:
        """Return the lazy grid's data for equation cells, and add their kernels to the grid."""
        if len(self._grid.blocks):
            codes = with_kernels(self._grid.codes, LOOK_AT_BLOCKS, ADVANCE_ROW)
            self._take(handle(self._grid._replace(codes=codes)))
        return load_lazy_blocks(self._grid, self.network)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        if self._lazy is None:
            super()._do_set_current(currents_na)
            return
        require_input(self.network, currents_na)
        total = offsets_of(self._grid, self._cells) + currents_na[self._grid.ids]
        set_currents(self._held.places, self._lazy.places, total)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        if self._lazy is not None:
            show_all(self._held.places, self._lazy.places, self._row_of[neurons])
        return super()._do_read_state(variable, neurons)

    def _do_set_parameters(self, change: ParameterChange) -> None:
        if self._lazy is None:
            super()._do_set_parameters(change)
            return
        self._check_receptors(change)
        self._leave()
        super()._do_set_parameters(change)
        n_kinds = len(kinds_of(self._grid, self._cells)[0]) + n_kinds_of_blocks(self._grid, self.network)
        if n_kinds <= MOST_KINDS:
            self._enter()

    def _check_receptors(self, change: ParameterChange) -> None:
        """Refuse to part the inputs of both receptors, which are one while they decay alike."""
        own = self.network.populations[change.label].equations is not None
        if own or not change.values.keys() & TIME_CONSTANTS.keys():
            return
        rows = self._row_of[self.network.offsets[change.label] + change.index]
        before = self._cells["tau_syn"][rows]
        after = [change.values.get(name, before[:, k]) for name, k in TIME_CONSTANTS.items()]
        if ((before[:, 0] == before[:, 1]) & (after[0] != after[1])).any():
            raise CapabilityError(
                f"tau_syn_E and tau_syn_I of population '{change.label}' are equal, and the lazy grid does "
                "not keep their inputs apart; set both, or run with `lazy: never`"
            )

    def _start(self) -> None:
        super()._start()
        self._enter()

    def _do_save(self) -> object:
        return super()._do_save(), None if self._lazy is None else changing(self._lazy.arrays)

    def _do_restore(self, saved: Any) -> None:
        plain, own = saved
        super()._do_restore(plain)
        self._lazy = None
        if own is not None:
            own = own[0] if isinstance(own, tuple) else own  # version 0.2 saved the kinds too
            fresh = self._of_blocks()
            arrays = {**fresh, **{name: array.copy() for name, array in own.items()}}
            arrays["blocks"]["code"] = fresh["blocks"]["code"]
            kinds, _, courses = load_kinds(self._grid, self._cells)
            self._lazy = handle(Lazy(kinds=kinds, courses=courses, **arrays))

    def _do_close(self) -> None:
        super()._do_close()
        self._lazy = None
