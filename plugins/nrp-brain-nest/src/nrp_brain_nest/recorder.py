"""The spikes of all neurons of a network in NEST."""

from __future__ import annotations

from typing import Any

import numpy as np
from nrp_core.brain import Grid, IntArray, Spikes

from nrp_brain_nest.status import put


class Recorder:
    """A recorder of NEST that is emptied when its spikes are taken.

    Args:
        nest: the module.
        nodes: NEST's id of each global id, 0 for cells that are not in NEST.
        grid: NEST's time grid.
        delay_ms: a delay that NEST's range of delays contains.
    """

    def __init__(self, nest: Any, nodes: IntArray, grid: Grid, *, delay_ms: float = 1.0) -> None:
        self._nest, self._grid, self._synapse = nest, grid, {"delay": delay_ms}
        self._recorder = nest.Create("spike_recorder", params={"time_in_steps": True})
        self._ids = np.zeros(1 + nodes.max(initial=0), np.int64)
        self._ids[nodes] = np.arange(len(nodes))

    def listen(self, nodes: IntArray) -> None:
        """Record the spikes of nodes.

        Raises:
            NESTError: they send none.
        """
        if len(nodes):
            collection = self._nest.NodeCollection(np.sort(nodes).tolist())
            self._nest.Connect(collection, self._recorder, syn_spec=self._synapse)

    def take(self) -> Spikes:
        """Return and delete the spikes so far, at the ends of their steps."""
        events = self._recorder.get("events")
        if not len(events["senders"]):
            return Spikes()
        put(self._recorder, [{"n_events": 0}])
        return Spikes(self._ids[events["senders"]], self._grid.time_ms(events["times"]))
