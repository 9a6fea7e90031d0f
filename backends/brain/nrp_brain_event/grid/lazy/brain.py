"""A network on the lazy grid."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from nrp_brain_event.cell_types import TIME_CONSTANTS
from nrp_brain_event.grid.brain import GridBrain
from nrp_brain_event.grid.lazy.advance import run
from nrp_brain_event.grid.lazy.changes import set_currents
from nrp_brain_event.grid.lazy.choice import MOST_KINDS
from nrp_brain_event.grid.lazy.loader import Kinds, changing, from_plain, kinds_of, load_kinds, to_plain
from nrp_brain_event.grid.lazy.records import Lazy
from nrp_brain_event.grid.lazy.show import show_all
from nrp_brain_event.grid.live import offsets_of
from nrp_brain_event.grid.loader import enlarged
from nrp_brain_event.handles import Handle, handle
from nrp_brain_event.records import FULL
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import COMPILED
from nrp_core.brain.changes import ParameterChange
from nrp_core.errors import CapabilityError

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

    It goes on as a plain grid where so many events occur that this is cheaper. This is judged by counts, at
    certain steps, so a run is the same however it is divided.
    """

    _lazy: Handle[Lazy] | None = None
    """None where the plain grid has taken over."""
    _kinds: Kinds

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
        self._kinds = load_kinds(self._grid, self._cells)
        self._lazy = handle(from_plain(self._grid, self._kinds))

    def _do_set_current(self, currents_na: FloatArray) -> None:
        if self._lazy is None:
            super()._do_set_current(currents_na)
            return
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
        if len(kinds_of(self._grid, self._cells)[0]) <= MOST_KINDS:
            self._enter()

    def _check_receptors(self, change: ParameterChange) -> None:
        """Refuse to part the inputs of both receptors, which are one while they decay alike."""
        if not change.values.keys() & TIME_CONSTANTS.keys():
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
        own = None if self._lazy is None else (changing(self._lazy.arrays), self._kinds)
        return super()._do_save(), own

    def _do_restore(self, saved: Any) -> None:
        plain, own = saved
        super()._do_restore(plain)
        self._lazy = None
        if own is not None:
            arrays, self._kinds = own
            kinds, _, courses = self._kinds
            copies = {name: array.copy() for name, array in arrays.items()}
            self._lazy = handle(Lazy(kinds=kinds, courses=courses, **copies))

    def _do_close(self) -> None:
        super()._do_close()
        self._lazy = None
