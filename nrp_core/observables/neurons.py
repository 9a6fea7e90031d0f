"""Observables of neurons: rate, voltage, weight. They have values at the steps of the loop."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_S
from nrp_core.errors import ExperimentError
from nrp_core.observables.observable import Observable, Surroundings
from nrp_core.quantities import DurationNs


class _OfBrain(Observable):
    def __init__(self, around: Surroundings, of: str) -> None:
        self._around, self._of = around, of

    def _brain(self) -> Brain:
        if self._around.brain is None:
            raise ExperimentError(f"{self.name} is not known before the brain is opened")
        return self._around.brain


class Rate(_OfBrain):
    """The mean rate of the neurons of a population or view in the last second, or another window, Hz.

    Before the end of the first window it has no value.
    """

    unit = "Hz"

    def __init__(self, around: Surroundings, of: str, window: DurationNs = NS_PER_S) -> None:
        super().__init__(around, of)
        self._window_ns, self.name = window, f"the rate of {of}"
        self._counts: deque[tuple[int, int]] = deque()

    def value(self, now_ns: int) -> float | None:
        assert self._around.spikes is not None
        size = len(self._brain().network.neurons(self._of))
        if not self._counts or self._counts[-1][0] < now_ns:
            self._counts.append((now_ns, self._around.spikes()[self._of]))
        while len(self._counts) > 1 and self._counts[1][0] <= now_ns - self._window_ns:
            self._counts.popleft()
        since_ns, before = self._counts[0]
        if now_ns - since_ns < self._window_ns:
            return None
        return (self._counts[-1][1] - before) / size / ((self._counts[-1][0] - since_ns) / NS_PER_S)

    def save(self) -> Any:
        return tuple(self._counts)

    def restore(self, saved: Any) -> None:
        self._counts = deque(saved)


class Voltage(_OfBrain):
    """The mean membrane voltage of a population or view, mV."""

    unit = "mV"

    def __init__(self, around: Surroundings, of: str) -> None:
        super().__init__(around, of)
        self.name = f"the voltage of {of}"

    def value(self, now_ns: int) -> float:
        brain = self._brain()
        return float(np.mean(brain.read_state("v", brain.network.neurons(self._of))))


class Weight(_OfBrain):
    """The mean weight of a projection, in the unit of its synapses (nA or uS)."""

    def __init__(self, around: Surroundings, of: str) -> None:
        super().__init__(around, of)
        self.name = f"the weight of {of}"

    def value(self, now_ns: int) -> float:
        return float(np.mean(self._brain().read_weights(self._of)))
