"""The synapses of projections in NEST, which stores them in a different order."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from nrp_core.brain import FloatArray, IntArray, same_order
from nrp_core.clock import nanoseconds

Synapses = tuple[IntArray, IntArray, Mapping[str, FloatArray]]


class Link:
    """The synapses of one projection.

    Args:
        nest: the module.
        model: NEST's synapse model; no other projection between these nodes has it.
        made: returns the data of the synapses: NEST ids of their ends, and their values in NEST's units, each
            of shape ``(n,)``; they are computed each time to save memory.
    """

    def __init__(self, nest: Any, model: str, made: Callable[[], Synapses]) -> None:
        self._nest, self.model, self._made = nest, model, made
        self._changed: dict[str, FloatArray] = {}

    def read(self, name: str) -> FloatArray:
        """Return the present value of a parameter of each synapse, in the order of the projection."""
        synapses, ours, theirs = self._found()
        now = np.empty(len(ours))
        now[ours] = np.atleast_1d(synapses.get(name))[theirs]
        return now

    def set(self, name: str, values: FloatArray) -> None:
        """Set a parameter of each synapse."""
        synapses, ours, theirs = self._found()
        wanted = np.empty(len(ours))
        wanted[theirs] = values[ours]
        synapses.set([{name: value} for value in wanted.tolist()])
        self._changed[name] = values

    def raise_shared(self, name: str, amount: float) -> None:
        """Add to a value that all synapses have in common."""
        synapses, *_ = self._found()
        synapses.set({name: float(np.atleast_1d(synapses.get(name))[0]) + amount})

    def _found(self) -> tuple[Any, IntArray, IntArray]:
        """Return NEST's synapses, and the sort orders that match ours to NEST's."""
        pre, post, values = self._made()
        ends = (self._nest.NodeCollection(np.unique(ids).tolist()) for ids in (pre, post))
        synapses = self._nest.GetConnections(*ends, synapse_model=self.model)
        ours = {**values, **self._changed, "source": pre, "target": post}
        theirs = synapses.get(list(ours))
        return synapses, *same_order(
            *(known | {"delay": nanoseconds(known["delay"])} for known in (ours, theirs))
        )
