"""Event-driven brains that advance together: the primitives, each one call for all brains."""

from __future__ import annotations

from collections.abc import Sequence
from operator import is_not
from typing import Any, Final

import numpy as np

from nrp_brain_event.engine import MOST_SORTED, sort_spikes
from nrp_brain_event.handles import opened
from nrp_brain_event.kernels import post, run
from nrp_brain_event.records import DONE, Array, EngineArrays
from nrp_core._support.arrays import IntArray, address
from nrp_core._support.jit import array_at, jit
from nrp_core._support.signals import end_if_asked
from nrp_core.brain.engines import Engines
from nrp_core.brain.spikes import NO_SPIKES, Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS
from nrp_core.simulation import Failures

_PLACES: Final = np.empty(0, np.int64)
_SIZE: Final = 3 * len(EngineArrays._fields)


class EventEngines(Engines):
    """See :class:`~nrp_core.brain.together.Engines`."""

    def __init__(self) -> None:
        self._known: list[Any] = []
        self._table = np.empty(0, np.int64)

    def _engines(self, brains: Sequence[Any]) -> Array:
        """Return the addresses of the address tables of all engines."""
        places = [brain._places for brain in brains]
        if len(places) != len(self._known) or any(map(is_not, places, self._known)):
            self._known, self._table = places, np.array([address(one) for one in places], np.int64)
        return self._table

    def inject(
        self, brains: Sequence[Any], counts: IntArray, events: SynapticEvents, kinds: IntArray
    ) -> Failures:
        each, failed = counts.sum(axis=1), Failures()
        ends = each.cumsum()
        done, given = ends - each, (events.neurons, events.times_ms, events.weights, kinds)
        while (full := inject_each(self._engines(brains), *given, done, ends)) >= 0:
            try:
                brains[full]._enlarge()
            except Exception as error:  # noqa: BLE001 - the caller decides about each brain
                failed[full], done[full] = error, ends[full]
        return failed

    def run(self, brains: Sequence[Any], times_ns: Sequence[int]) -> Failures:
        until_ms = np.array(times_ns) / NS_PER_MS
        status, failed = np.empty(len(brains), np.int64), Failures()
        end_if_asked()
        run_each(self._engines(brains), until_ms, np.nextafter(until_ms, np.inf), status)
        for number in np.flatnonzero(status != DONE).tolist():
            try:
                brains[number]._go_on(status.item(number), times_ns[number])
                brains[number]._run_to(times_ns[number])
            except Exception as error:  # noqa: BLE001 - the caller decides about each brain
                failed[number] = error
        return failed

    def take(self, brains: Sequence[Any]) -> tuple[IntArray, Spikes]:
        ends = np.empty(len(brains), np.int64)
        engines = self._engines(brains)
        longest = count_each(engines, ends)
        n = int(ends[-1])
        if not n:
            return ends, NO_SPIKES
        neurons, times_ms = np.empty(n, np.int64), np.empty(n)
        take_each(engines, neurons, times_ms)
        first = 0
        for last in ends.tolist() if longest > MOST_SORTED else ():
            own = slice(first, last)
            part = Spikes.merged([Spikes(neurons[own], times_ms[own])])
            neurons[own], times_ms[own], first = part.neurons, part.times_ms, last
        return ends, Spikes(neurons, times_ms)


@jit
def inject_each(
    engines: Array, neurons: Array, times: Array, weights: Array, kinds: Array, done: Array, ends: Array
) -> int:
    """Schedule the events of each engine that are not done; return an engine without room, or -1."""
    for i in range(len(engines)):
        if done[i] == ends[i]:
            continue
        engine = opened(EngineArrays, array_at(engines[i], _SIZE, _PLACES))
        clock, slots, events, row_of = engine.clock[0], engine.event_slots, engine.events, engine.row_of
        for k in range(done[i], ends[i]):
            if clock.n_free == 0:
                done[i] = k
                return i
            post(clock, slots, events, times[k], 2 * row_of[neurons[k]] + kinds[k], weights[k], 0)
        done[i] = ends[i]
    return -1


@jit
def run_each(engines: Array, until: Array, end: Array, status: Array) -> None:
    """Simulate each engine with :func:`run`, and store the results."""
    for i in range(len(engines)):
        places = array_at(engines[i], _SIZE, _PLACES).reshape((_SIZE // 3, 3))
        status[i] = run(places, until[i], end[i])


@jit
def count_each(engines: Array, ends: Array) -> int:
    """Sort the new spikes of each engine, unless there are many, and store where those of each will end.

    Returns:
        The largest number of new spikes of one engine.
    """
    n, most = 0, 0
    for i in range(len(engines)):
        engine = opened(EngineArrays, array_at(engines[i], _SIZE, _PLACES))
        own = engine.clock[0].n_spikes
        if 1 < own <= MOST_SORTED:
            sort_spikes(engine.spikes, own)
        n, most = n + own, max(most, own)
        ends[i] = n
    return most


@jit
def take_each(engines: Array, neurons: Array, times: Array) -> None:
    """Store and clear the new spikes of all engines, one after the other."""
    n = 0
    for i in range(len(engines)):
        engine = opened(EngineArrays, array_at(engines[i], _SIZE, _PLACES))
        clock = engine.clock[0]
        for k in range(clock.n_spikes):
            neurons[n], times[n] = engine.spikes[k].id, engine.spikes[k].time
            n += 1
        clock.n_spikes = 0
