"""What populations of sPyNNaker record: with the times of a machine, and the changes of their synapses."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import Any, Final

import numpy as np
from neo import Event
from pyNN import recording
from quantities import ms

from nrp_core.brain import FloatArray, IntArray
from nrp_core.clock import from_milliseconds, milliseconds, nanoseconds
from nrp_core.errors import NetworkError, NrpError
from nrp_core.network.changes import Rewirings
from nrp_core.pynn.recorder import Recorder

REWIRING: Final = recording.Variable(name="rewiring", location=None, label=None)
_KINDS: Final[tuple[Any, ...]] = (("form", "formation", True), ("elim", "elimination", False))


def events_of(changes: Iterable[Rewirings], since_ms: float) -> list[Any]:
    """Return the changes of all projections onto a population from a time on, by time and cells.

    Their form is that of sPyNNaker 7.4.1: an event ``rewiring_form`` and an event ``rewiring_elim``, with
    labels such as ``3_5_formation`` (source cell 3, target cell 5).
    """
    every = [*changes]
    nothing = np.empty(0)
    time_ms, pre, post, formed = (
        np.concatenate([nothing, *(getattr(one, name) for one in every)])
        for name in ("time_ms", "pre_index", "post_index", "formed")
    )
    order = np.lexsort((formed, post, pre, time_ms))
    order = order[nanoseconds(time_ms[order]) >= from_milliseconds(since_ms)]
    columns = [each[order] for each in (time_ms, pre, post)]
    chosen = {flag: formed[order] == flag for flag in (True, False)}
    return [_event(*names, *(each[chosen[flag]] for each in columns)) for *names, flag in _KINDS]


def _event(name: str, change: str, time_ms: FloatArray, pre: FloatArray, post: FloatArray) -> Any:
    labels = [f"{a:.0f}_{b:.0f}_{change}" for a, b in zip(pre, post, strict=True)]
    return Event(
        times=time_ms * ms, labels=np.array(labels, dtype=str), name=f"{REWIRING.name}_{name}",
        description=f"Synapse {change} events",
    )  # fmt: skip


class LabelledRecorder(Recorder):
    """PyNN's recorder, with the times of a machine, and the synapses that form and vanish."""

    def __init__(self, population: Any, file: Any = None) -> None:
        super().__init__(population, file)
        self._kept: list[Rewirings] = []

    def keep(self) -> None:
        """Keep the data that only the brain has, before it is closed."""
        if REWIRING in self.recorded:
            with suppress(NrpError):  # a brain that has failed has no data
                self._kept = self._simulator.state.rewirings_onto(self.population)

    def _names(self) -> set[str]:
        return super()._names() - {REWIRING.name}

    def _listen(self, variable: Any, ids: Iterable[Any]) -> None:
        if variable != REWIRING:
            super()._listen(variable, ids)

    def _get_current_segment(
        self, filter_ids: Any = None, variables: Any = "all", clear: bool = False
    ) -> Any:
        chosen = set(self.recorded) if variables == "all" else set(self.recorded) & set(variables)
        segment = super()._get_current_segment(filter_ids, chosen - {REWIRING}, clear)
        if REWIRING in chosen:
            segment.events += self._rewirings(filter_ids)
        return segment

    def _rewirings(self, filter_ids: Any) -> list[Any]:
        owner = f"population '{self.population.label}'"
        if filter_ids is not None and len(set(filter_ids)) < self.population.size:
            raise NetworkError(f"{owner}: 'rewiring' is of all its cells; take get_data of the population")
        state = self._simulator.state
        changes = self._kept if state.brain is None else state.rewirings_onto(self.population)
        return events_of(changes, milliseconds(self._begin_ns))

    def _get_spiketimes(self, ids: Iterable[Any], clear: bool = False) -> tuple[IntArray, FloatArray]:
        neurons, times = super()._get_spiketimes(ids, clear)
        state = self._simulator.state
        if self.population.celltype.receptor_types:
            return neurons, (np.rint(times / state.dt) - 1) * state.dt
        step_us = round(state.dt * 1000)
        steps = -(np.floor(times * 1000).astype(np.int64) // -step_us)  # as sPyNNaker does
        begun = steps < round(state.t / state.dt)  # the others are of the next step
        return neurons[begun], np.multiply(steps[begun], float(state.dt))

    def _get_all_signals(
        self, variable: Any, ids: Iterable[Any], clear: bool = False
    ) -> tuple[FloatArray, None]:
        signals, _ = super()._get_all_signals(variable, ids, clear)
        lasted_ns = from_milliseconds(self._simulator.state.t) - self._begin_ns
        return signals[: -(-lasted_ns // from_milliseconds(self.sampling_interval))], None
