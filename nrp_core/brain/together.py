"""Brains of the copies of an experiment advance together, by one call of compiled code.

Each brain has the same spikes as alone, bit for bit, because the same compiled functions are called in the
same order. A brain with currents, recorders of state or source populations advances alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray, address
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.brain.devices.trains import TrainPort
from nrp_core.brain.engines import Engines
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import NO_SPIKES, Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import DivergedError
from nrp_core.simulation import Failures, note_failure

_is_active = attrgetter("active")


class _Row:
    """The addresses of the devices of a brain, valid while the same devices are attached."""

    def __init__(self, brain: Brain) -> None:
        attached = brain._attached
        self.devices = attached.acting
        sinks: list[SinkPort] = attached.sinks
        self.is_plain = not (attached.trains or attached.currents or attached.recorders or attached.injected)
        self.trains: list[Any] = [port for port in attached.acting if isinstance(port, TrainPort)]
        self.is_plain &= len(self.trains) == len(attached.acting) and all(
            port.is_endless and port.synapses is None for port in self.trains
        )
        self.filters: list[Any] = [port for port in sinks if port.filtering]
        self.counters = [port for port in sinks if port.counted is not None]
        self.others = [port for port in sinks if not port.filtering and port.counted is None]
        self.places = [port.place for port in self.trains]
        self.membranes = [port.filtering for port in self.filters]
        self.counts = [address(port.counted) for port in self.counters if port.counted is not None]
        self.engines = brain._engines()
        lengths = len(self.places), len(self.membranes), len(self.counts)
        self.shape = type(brain), type(self.engines), brain.network.size, *lengths


class BrainBatch:
    """Advances brains of one network together."""

    def __init__(self) -> None:
        self._rows: dict[Brain, _Row] = {}
        self._table: tuple[tuple[_Row, ...], list[IntArray]] = ((), [])
        self._engines = Engines()

    def run_until(self, brains: Sequence[Brain], times_ns: Sequence[int]) -> Failures:
        """Advance each brain to its time; one that fails does not stop the others.

        Returns:
            The errors of the brains that failed, as their own ``run_until`` raises them.
        """
        together, failed = self._chosen(brains, times_ns), {}
        if together:
            failed = self._advance([brains[n] for n in together], [times_ns[n] for n in together])
            failed = {together[number]: error for number, error in failed.items()}
        chosen = set(together)
        for number in (number for number in range(len(brains)) if number not in chosen):
            note_failure(failed, number, partial(brains[number].run_until, times_ns[number]))
        return failed

    def _chosen(self, brains: Sequence[Brain], times_ns: Sequence[int]) -> list[int]:
        """Return the numbers of the brains that can advance together: their devices are alike."""
        found: list[int] = []
        rows, shape = self._rows, None
        for number, brain in enumerate(brains):
            row = rows.get(brain)
            if row is None or row.devices is not brain._attached.acting:
                row = rows[brain] = _Row(brain)
            if not row.is_plain or not brain._is_plain or brain.now_ns >= times_ns[number]:
                continue
            if row.counters and not all(map(_is_active, row.counters)):
                continue  # compiled code counts without a look at them
            shape = shape or row.shape
            if shape == row.shape:
                found.append(number)
        return found

    def _tables(self, brains: Sequence[Brain]) -> list[IntArray]:
        """Return the addresses of sources, membranes and counters; a row for each brain."""
        rows = tuple(map(self._rows.__getitem__, brains))
        if rows != self._table[0]:
            each = zip(*((row.places, row.membranes, row.counts) for row in rows), strict=True)
            self._table = rows, [np.array(one, np.int64).reshape(len(rows), -1) for one in each]
        return self._table[1]

    def _advance(self, brains: Sequence[Brain], times_ns: Sequence[int]) -> Failures:
        self._engines = self._rows[brains[0]].engines
        trains, membranes, counters = self._tables(brains)
        since_ms = np.array([brain.now_ns for brain in brains]) / NS_PER_MS
        until_ms = np.array(times_ns) / NS_PER_MS
        failed = self._emit(brains, trains, since_ms, until_ms)
        failed = self._engines.run(brains, times_ns) | failed
        ends, spikes = self._engines.take(brains)
        if len(spikes) and not np.isfinite(spikes.times_ms).all():
            self._note_infinite(brains, times_ns, ends, spikes, failed)
        self._receive(brains, (membranes, counters), until_ms, ends, spikes)
        for number, (brain, t_ns) in enumerate(zip(brains, times_ns, strict=True)):
            if number not in failed:
                brain.now_ns = t_ns
                continue
            note_failure(failed, number, partial(brain.fail, "advance", failed[number]))
        return failed

    def _emit(
        self, brains: Sequence[Brain], trains: IntArray, since_ms: FloatArray, until_ms: FloatArray
    ) -> Failures:
        """Deliver the spikes of the sources."""
        from nrp_core.brain.devices import train_kernel  # imported here since it loads a compiler

        counts = np.empty(trains.shape, np.int64)
        train_kernel.due_each(trains, since_ms, until_ms, counts)
        for i, k in np.argwhere(counts < 0).tolist():
            port = self._rows[brains[i]].trains[k]
            counts[i, k] = port.due(since_ms.item(i), until_ms.item(i))
        n = int(counts.sum())
        if not n:
            return {}
        neurons, kinds = np.empty((2, n), np.int64)
        times_ms, weights = np.empty((2, n))
        train_kernel.take_each(trains, counts, neurons, times_ms, weights, kinds)
        return self._engines.inject(brains, counts, SynapticEvents(neurons, times_ms, weights), kinds)

    def _receive(
        self,
        brains: Sequence[Brain],
        tables: tuple[IntArray, IntArray],
        until_ms: FloatArray,
        ends: IntArray,
        spikes: Spikes,
    ) -> None:
        """Give each sink the spikes of its brain."""
        from nrp_core.brain.devices import membrane_kernel  # imported here since it loads a compiler

        (membranes, counters), done = tables, 0
        neurons, times_ms = spikes.neurons, spikes.times_ms
        rows = [self._rows[brain] for brain in brains]
        while membranes.size and done < membranes.size:
            done = membrane_kernel.receive_each(membranes, until_ms, ends, neurons, times_ms, done)
            if done < membranes.size:
                i, k = divmod(done, membranes.shape[1])
                rows[i].filters[k].make_room()
        if counters.size and len(spikes):
            membrane_kernel.count_each(counters, brains[0].network.size, ends, neurons)
        first = 0
        for number, (row, last) in enumerate(zip(rows, ends.tolist(), strict=True)):
            for sink in row.others:
                own = slice(first, last)
                part = Spikes(neurons[own].copy(), times_ms[own].copy()) if first < last else NO_SPIKES
                sink.receive(part, until_ms.item(number))
            first = last

    def _note_infinite(
        self,
        brains: Sequence[Brain],
        times_ns: Sequence[int],
        ends: IntArray,
        spikes: Spikes,
        failed: Failures,
    ) -> None:
        """Store an error for each brain that returned a spike time that is not finite."""
        for place in np.flatnonzero(~np.isfinite(spikes.times_ms)).tolist():
            number = int(ends.searchsorted(place, "right"))
            message = f"{type(brains[number]).__name__} returned a spike time that is not finite"
            failed.setdefault(number, DivergedError(message, t_ns=times_ns[number]))
