"""Changes of weights in simulators that use the weight at a spike's arrival and not at its emission.

In these a synapse gets its new weight after the arrival of the last spike emitted before the change.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from nrp_core.brain import STDP, FloatArray, IntArray, Projection

from nrp_brain_pynn.driver import Driver


class LateWeightsDriver(Driver):
    """A driver of a simulator that sets weights late.

    Attributes:
        arrival_steps: maximum number of steps from the arrival of a spike to its effect.
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
        """Set weights of synapses of a projection now."""

    def _weights_now(self, projection: Projection) -> FloatArray:
        """Return the weights of plastic synapses."""
        raise NotImplementedError(projection.label)
