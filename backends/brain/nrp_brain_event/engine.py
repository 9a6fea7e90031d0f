"""The engine's arrays: made from a network, enlarged, copied."""

from __future__ import annotations

from math import floor, log2
from typing import Final

import numpy as np

from nrp_brain_event.cells import load_cells
from nrp_brain_event.connections import delay_range, load_connections
from nrp_brain_event.records import CONSTANT, Array, Clock, Engine, Event, Spike, Work
from nrp_core.brain.network import Network

_ROOM: Final = 1024
"""Events and spikes for which there is room at first."""
_LONGEST_WINDOW_MS: Final = 1.0
_FEWEST_WINDOWS: Final = 64
_MOST_WINDOWS: Final = 4096


def build_engine(network: Network, tolerance_mv: float) -> Engine:
    """Return the engine of a network at time 0, all neurons about to start.

    Raises:
        NetworkError: the network has parameters or delays that cannot be.
    """
    shortest_ms, longest_ms = delay_range(network)
    width_ms = 2.0 ** floor(log2(min(shortest_ms, _LONGEST_WINDOW_MS)))
    n_windows = min(max(int(longest_ms / width_ms) + 2, _FEWEST_WINDOWS), _MOST_WINDOWS)
    n_windows = 1 << (n_windows - 1).bit_length()
    cells, row_of = load_cells(network, tolerance_mv)
    clock, events = np.zeros(1, Clock.dtype()), np.zeros(_ROOM, Event.dtype())
    clock["width"], clock["per_width"] = width_ms, 1.0 / width_ms
    _chain_free(clock, events, 0)
    return Engine(
        cells=cells,
        row_of=row_of,
        **load_connections(network, cells, row_of),
        clock=clock,
        events=events,
        event_slots=np.full(n_windows + 1, -1),
        cell_slots=_first_window(cells, n_windows),
        ready=np.zeros(len(cells), np.int64),
        spikes=np.zeros(_ROOM, Spike.dtype()),
        work=np.zeros(1, Work.dtype()),
    )


def enlarged(engine: Engine) -> Engine:
    """Return the engine with twice the room for spikes, if that is used up, else for events."""
    clock, n_events = engine.clock, len(engine.events)
    if clock["n_spikes"][0] == len(engine.spikes):
        return engine._replace(spikes=_doubled(engine.spikes))
    events = _doubled(engine.events)
    _chain_free(clock, events, n_events)
    return engine._replace(events=events)


def changing(engine: Engine, initial: Engine | None = None) -> dict[str, Array]:
    """Return copies of all arrays that change while running, by name.

    Args:
        engine: whose.
        initial: the engine at time 0, to include what others have changed since.
    """
    return {
        name: array.copy()
        for name, array in engine._asdict().items()
        if name not in CONSTANT or (initial is not None and array is not getattr(initial, name))
    }


def _doubled(array: Array) -> Array:
    larger = np.zeros(2 * len(array), array.dtype)
    larger[: len(array)] = array
    return larger


def _chain_free(clock: Array, events: Array, first: int) -> None:
    """Put the events from ``first`` on at the head of the list of free ones."""
    events["after"][first:] = np.arange(first + 1, len(events) + 1)
    events["after"][-1] = clock["free"][0] if clock["n_free"][0] else -1
    clock["free"] = first
    clock["n_free"] += len(events) - first


def _first_window(cells: Array, n_windows: int) -> Array:
    """Return the calendar with all neurons in the first window."""
    slots = np.full(n_windows + 1, -1)
    if len(cells):
        slots[0] = cells["window"][:] = 0
        cells["before"] = np.arange(-1, len(cells) - 1)
        cells["after"] = np.arange(1, len(cells) + 1)
        cells["after"][-1] = -1
    return slots
