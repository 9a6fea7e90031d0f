"""The engine's arrays: made from a network, enlarged, copied."""

from __future__ import annotations

from math import floor, log2
from typing import Final

import numpy as np
from nrp_core.brain.network import Network

from nrp_brain_event.agenda import schedule
from nrp_brain_event.cells import load_cells
from nrp_brain_event.connections import load_connections
from nrp_brain_event.records import CLOCK, EVENT, SPIKE, WORK, Array, Engine

_ROOM: Final = 1024
"""Events and spikes for which there is room at first."""
_WINDOWS: Final = (64, 4096)
"""Fewest and most windows of the calendar; what lies further ahead is sorted in later."""


def build_engine(network: Network, tolerance_mv: float) -> Engine:
    """Return the engine of a network at time 0.

    Raises:
        NetworkError: the network has parameters or delays that cannot be.
    """
    cells, row_of = load_cells(network, tolerance_mv)
    connections = load_connections(network, cells, row_of)
    clock = np.zeros(1, CLOCK)
    width = 2.0 ** floor(log2(connections.shortest_delay_ms))
    clock["width"], clock["free"] = width, -1
    horizon = int(connections.longest_delay_ms / width) + 2
    n_windows = 1 << (min(max(horizon, _WINDOWS[0]), _WINDOWS[1]) - 1).bit_length()
    engine = Engine(
        cells=cells,
        row_of=row_of,
        first=connections.first,
        target=connections.target,
        weight=connections.weight,
        delay=connections.delay,
        dynamics=connections.dynamics,
        short_term=connections.short_term,
        clock=clock,
        events=np.zeros(0, EVENT),
        event_slots=np.full(n_windows + 1, -1),
        cell_slots=np.full(n_windows + 1, -1),
        ready=np.zeros(len(cells), np.int64),
        spikes=np.zeros(0, SPIKE),
        work=np.zeros(1, WORK),
    )
    for row in range(len(cells)):
        schedule(clock[0], engine.cell_slots, cells, row)
    return with_room(engine, _ROOM, _ROOM)


def with_room(engine: Engine, events: int, spikes: int) -> Engine:
    """Return the engine with room for at least so many more events and spikes."""
    clock = engine.clock[0]
    missing = max(0, events - int(clock.n_free))
    if missing:
        engine = engine._replace(events=_more_events(engine, max(missing, len(engine.events))))
    missing = max(0, spikes - (len(engine.spikes) - int(clock.n_spikes)))
    if missing:
        more = np.zeros(max(missing, len(engine.spikes)), SPIKE)
        engine = engine._replace(spikes=np.concatenate([engine.spikes, more]))
    return engine


def copied(engine: Engine) -> Engine:
    """Return the engine with arrays of its own; what never changes is shared."""
    constant = {"row_of", "first", "target", "weight", "delay", "dynamics"}
    arrays = {name: array.copy() for name, array in engine._asdict().items() if name not in constant}
    return engine._replace(**arrays)


def _more_events(engine: Engine, n: int) -> Array:
    """Return the pool enlarged by n events, the new ones at the head of the list of free ones."""
    clock, n_before = engine.clock[0], len(engine.events)
    more = np.zeros(n, EVENT)
    more["after"] = np.arange(n_before + 1, n_before + n + 1)
    more["after"][-1] = clock.free
    clock.free = n_before
    clock.n_free += n
    return np.concatenate([engine.events, more])
