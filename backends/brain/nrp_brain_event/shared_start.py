"""The initial engine of a network, which the brains of all copies of an experiment share."""

from __future__ import annotations

from typing import Final
from weakref import WeakValueDictionary

from nrp_brain_event.engine import build_engine
from nrp_brain_event.records import EngineArrays
from nrp_core.network.data import Network

_MOST_BYTES: Final = 1 << 22
"""A larger engine is not shared: each brain builds its own."""


class Start:
    """An initial engine; it is shared as long as one of its brains is open.

    Args:
        network: the network for which it was built.
        engine: its arrays, with all neurons in their initial state.
    """

    def __init__(self, network: Network, engine: EngineArrays) -> None:
        self.network, self.engine = network, engine


_starts: WeakValueDictionary[tuple[int, float, bool], Start] = WeakValueDictionary()


def start_of(network: Network, tolerance_mv: float, *, quadrature: bool) -> Start:
    """Return the engine of a network at time 0; it is shared if its brains write only into copies.

    Raises:
        NetworkError: the network has impossible parameters or delays.
    """
    key = id(network), tolerance_mv, quadrature  # no other network has this id while the start refers to it
    start = _starts.get(key)
    if start is None:
        start = Start(network, build_engine(network, tolerance_mv, quadrature=quadrature))
        arrays = start.engine
        changes = len(arrays.plastic) or len(arrays.short_term)
        if not changes and sum(array.nbytes for array in arrays) <= _MOST_BYTES:
            _starts[key] = start
    return start
