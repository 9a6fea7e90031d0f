"""Weights that change in simulators which look at a weight when a spike arrives, and not when it sets out.

There each synapse gets its new weight when the last spike that set out before the change has arrived.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from nrp_core.brain import STDP, FloatArray, IntArray, Projection

from nrp_brain_pynn.driver import Driver


class LateWeightsDriver(Driver):
    """A driver of such a simulator.

    Attributes:
        arrival_steps: how long after the time of its arrival a spike has acted at the latest.
    """

    arrival_steps: ClassVar[int] = 0

    def _begin(self) -> None:
        self._step = 0
        self._weights: dict[str, FloatArray] = {}
        self._late: dict[int, list[tuple[Projection, IntArray, FloatArray]]] = {}

    def read_weights(self, projection: Projection) -> FloatArray:
        if projection.synapse_type == STDP and projection.size:
            return self._weights_now(projection)
        return self._weights.get(projection.label, projection.weight).copy()

    def set_weights(self, projection: Projection, weights: FloatArray) -> None:
        """See :meth:`Driver.set_weights`; those of plastic synapses change for all spikes at once."""
        self._weights[projection.label] = weights
        if projection.synapse_type == STDP or self._step == 0:
            self._write(projection, np.arange(projection.size), weights)
            return
        delays = self.grid.delays(projection.delay_ms)
        for delay in np.unique(delays).tolist():
            index = np.flatnonzero(delays == delay)
            due = self._step + delay + self.arrival_steps
            self._late.setdefault(due, []).append((projection, index, weights[index]))

    def run_until(self, step: int) -> None:
        for due in sorted(at for at in self._late if at < step):
            self._pass(due)
            for change in self._late.pop(due):
                self._write(*change)
        self._finish(step)
        self._step = step

    @abstractmethod
    def _pass(self, step: int) -> None:
        """Simulate to a grid point before the end of the window."""

    @abstractmethod
    def _finish(self, step: int) -> None:
        """Simulate to the end of the window."""

    @abstractmethod
    def _write(self, projection: Projection, index: IntArray, weights: FloatArray) -> None:
        """Give synapses of a projection other weights now."""

    def _weights_now(self, projection: Projection) -> FloatArray:
        """Return the weights of plastic synapses."""
        raise NotImplementedError(projection.label)
