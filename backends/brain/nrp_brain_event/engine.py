"""The engine's arrays: creation from a network, enlargement, copies.

Takes the spikes that compiled code has stored.
"""

from __future__ import annotations

from math import floor, log2
from typing import Final

import numpy as np

from nrp_brain_event.cells import load_cells
from nrp_brain_event.connections import delay_range, load_connections
from nrp_brain_event.linear import modes_of
from nrp_brain_event.records import CONSTANT, Array, Clock, EngineArrays, Event, Link, Spike, Work
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.brain.spikes import NO_SPIKES, Spikes
from nrp_core.errors import NetworkError
from nrp_core.network.data import Network

MOST_SORTED: Final = 256
"""Spikes for which a plain sort is fast enough; more are sorted by NumPy."""


@jit
def sort_spikes(spikes: Array, n: int) -> None:
    """Sort the first spikes by time and neuron; they are nearly sorted."""
    for i in range(1, n):
        time, neuron = spikes[i].time, spikes[i].id
        k = i
        while k > 0 and (
            spikes[k - 1].time > time or (spikes[k - 1].time == time and spikes[k - 1].id > neuron)
        ):
            spikes[k].time, spikes[k].id = spikes[k - 1].time, spikes[k - 1].id
            k -= 1
        spikes[k].time, spikes[k].id = time, neuron


class StoredSpikes:
    """The new spikes of an engine.

    Args:
        clock: its clock, with their number ``n_spikes``.
        spikes: ``Spike``, the array that they are stored in.
    """

    def __init__(self, clock: Array, spikes: Array) -> None:
        # views, which are found once because every step needs them
        self._n, self._ids, self._times_ms = clock["n_spikes"], spikes["id"], spikes["time"]
        self._spikes = spikes

    def since(self, n: int) -> tuple[IntArray, FloatArray]:
        """Return neurons and times (ms) of the spikes from number ``n`` on, which stay."""
        end = self._n.item(0)
        return self._ids[n:end].copy(), self._times_ms[n:end].copy()

    def take(self) -> Spikes:
        """Return and clear the spikes, a few of them in order of time and neuron."""
        n = self._n.item(0)
        if not n:
            return NO_SPIKES
        self._n[0] = 0
        if 1 < n <= MOST_SORTED:
            sort_spikes(self._spikes, n)
        return Spikes(self._ids[:n].copy(), self._times_ms[:n].copy())


_ROOM: Final = 64
"""Initial capacity for events and spikes."""
_LONGEST_WINDOW_MS: Final = 1.0
_ARRIVALS_MS: Final = 4000.0
"""Length of a window times the number of delays of all neurons; few arrivals are sorted in fast caches."""
_FEWEST_WINDOWS: Final = 64
_MOST_WINDOWS: Final = 4096
_MOST_EVENTS: Final = 1 << 25
"""Maximum number of spikes in transit: 1.3 GB."""
_MOST_SPIKES: Final = 1 << 26
"""Maximum number of spikes within one step: 1.1 GB."""
_LISTS: Final = 64
"""Number of sorted lists, each of twice the length of the previous one: enough for all events."""


def build_engine(network: Network, tolerance_mv: float, *, quadrature: bool) -> EngineArrays:
    """Return the engine of a network at time 0, all neurons about to start.

    Raises:
        NetworkError: the network has impossible parameters or delays.
    """
    shortest_ms, longest_ms = delay_range(network)
    cells, row_of = load_cells(network, tolerance_mv, quadrature=quadrature)
    connections = load_connections(network, cells, row_of)
    n_arrivals = max(int(np.count_nonzero(connections["bundle"])), 1)
    width_ms = 2.0 ** floor(log2(min(shortest_ms, _LONGEST_WINDOW_MS, _ARRIVALS_MS / n_arrivals)))
    n_windows = min(max(int(longest_ms / width_ms) + 2, _FEWEST_WINDOWS), _MOST_WINDOWS)
    n_windows = 1 << (n_windows - 1).bit_length()
    modes, kinds = modes_of(cells)
    clock, events = np.zeros(1, Clock.dtype()), np.zeros(_ROOM, Event.dtype())
    clock["width"], clock["per_width"] = width_ms, 1.0 / width_ms
    clock["arriving"] = -1
    links = np.zeros(len(cells), Link.dtype())
    chain_free(clock, events, 0)
    return EngineArrays(
        cells=cells,
        modes=modes,
        kinds=kinds,
        row_of=row_of,
        **connections,
        clock=clock,
        events=events,
        event_slots=np.full(n_windows + 1, -1),
        cell_slots=_first_window(links, n_windows),
        links=links,
        sorting=np.full(_LISTS, -1),
        spikes=np.zeros(_ROOM, Spike.dtype()),
        work=np.zeros(1, Work.dtype()),
    )


def enlarged(engine: EngineArrays) -> EngineArrays:
    """Return the engine with twice the capacity for spikes, if that is used up, else for events."""
    clock, n_events = engine.clock, len(engine.events)
    if clock["n_spikes"][0] == len(engine.spikes):
        return engine._replace(spikes=doubled(engine.spikes))
    events = doubled(engine.events)
    chain_free(clock, events, n_events)
    return engine._replace(events=events)


def require_room(engine: EngineArrays, network: Network) -> None:
    """Check that there may be more events or spikes.

    Raises:
        NetworkError: there are too many; it names the population that has emitted most of the new spikes.
    """
    clock = engine.clock[0]
    n_spikes, n_events = int(clock["n_spikes"]), len(engine.events)
    spikes_full = n_spikes == len(engine.spikes)
    n, most = (n_spikes, _MOST_SPIKES) if spikes_full else (n_events, _MOST_EVENTS)
    if n < most:
        return
    what = "spikes since the last step" if spikes_full else "spikes in transit"
    source = ""
    if n_spikes:
        counts = np.bincount(engine.spikes["id"][:n_spikes], minlength=network.size)
        label, index = network.label_of(int(counts.argmax()))
        source = f"; cell {index} of population '{label}' has emitted {counts.max()} of {n_spikes} new spikes"
    raise NetworkError(
        f"the network has more than {most} {what} at {engine.clock['now'][0]:g} ms{source}; set a "
        "refractory period (`tau_refrac`), smaller currents or weights, shorter steps, or a grid, "
        "`resolution: 0.1 ms`"
    )


def changing(engine: EngineArrays, initial: EngineArrays | None = None) -> dict[str, Array]:
    """Return all arrays that change while running, by name.

    Args:
        engine: the engine.
        initial: the engine at time 0, to include arrays changed from outside since then.
    """
    return {
        name: array
        for name, array in engine._asdict().items()
        if name not in CONSTANT or (initial is not None and array is not getattr(initial, name))
    }


def doubled(array: Array) -> Array:
    """Return an array of twice the length, with the contents of another one."""
    larger = np.zeros(2 * len(array), array.dtype)
    larger[: len(array)] = array
    return larger


def chain_free(clock: Array, events: Array, first: int) -> None:
    """Add the events from ``first`` on to the front of the list of free ones."""
    events["after"][first:] = np.arange(first + 1, len(events) + 1)
    events["after"][-1] = clock["free"][0] if clock["n_free"][0] else -1
    clock["free"] = first
    clock["n_free"] += len(events) - first


def _first_window(links: Array, n_windows: int) -> Array:
    """Return the calendar with all neurons in the first window."""
    slots = np.full(n_windows + 1, -1)
    if len(links):
        slots[0] = 0
        links["before"] = np.arange(-1, len(links) - 1)
        links["after"] = np.arange(1, len(links) + 1)
        links["after"][-1] = -1
    return slots
