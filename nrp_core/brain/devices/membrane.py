"""The membrane of a neuron that never fires and receives spikes.

The state is kept at the last event; reading never changes the voltage, so the numbers do not depend on the
number of reads or on how a run is split.
"""

from __future__ import annotations

from math import exp
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.network.filters import MembraneKernel

_CONSTANTS: Final = ("alpha", "tau_m_ms", "tau_syn_ms", "cm_nf", "settled_mv")
_CHANGING: Final = ("at_ms", "current", "slope", "above")
_FIELDS: Final = [("waiting", "i8"), *((name, "f8") for name in (*_CONSTANTS, *_CHANGING))]
_DTYPE: Final = np.dtype((np.record, _FIELDS))
_ROOM: Final = 8


class LeakyMembrane:
    """The state of a :class:`MembraneKernel` under a train of weighted spikes.

    Spikes are added with their arrival times, in any order but not before the last read. A read at ``t`` sees
    those that arrived at or before ``t``.
    """

    def __init__(self, kernel: MembraneKernel) -> None:
        self._state = np.zeros(1, _DTYPE)
        for name in _CONSTANTS:
            self._state[name] = getattr(kernel, name)
        self._state["above"] = kernel.v_rest_mv - kernel.settled_mv
        self._queue = np.empty((2, _ROOM))
        self._compiled: Any = None  # loaded at the first spike

    def push(self, arrivals_ms: npt.ArrayLike, weights: npt.ArrayLike) -> None:
        """Add spikes: arrival times, ms, and weights, nA, shape ``(n,)``."""
        times, each = np.asarray(arrivals_ms, float), np.asarray(weights, float)
        self.receive(np.arange(len(times)), times, np.ones(len(times), np.bool_), each, 0.0)

    def receive(
        self,
        neurons: IntArray,
        times_ms: FloatArray,
        chosen: npt.NDArray[np.bool_],
        weights: FloatArray,
        delay_ms: float,
    ) -> None:
        """Add the spikes of chosen neurons, which arrive after a delay.

        Args:
            neurons: the neuron of each spike, shape ``(n,)``.
            times_ms: its time, ms.
            chosen: whether a neuron is chosen, by its number.
            weights: its weight, nA.
            delay_ms: the delay, ms.
        """
        if self._compiled is None:
            from nrp_core.brain.devices import membrane_kernel

            self._compiled = membrane_kernel
        while not self._compiled.enqueue(
            self._state, self._queue, neurons, times_ms, chosen, weights, delay_ms
        ):
            room = np.empty((2, 2 * self._queue.shape[1]))
            room[:, : self._queue.shape[1]] = self._queue
            self._queue = room

    def voltage_mv(self, t_ms: float) -> float:
        """Return the voltage at ``t_ms``, including all spikes that have arrived by then."""
        if self._compiled is None:
            rest = self._state[0]
            return float(rest["settled_mv"] + rest["above"] * exp(-t_ms / rest["tau_m_ms"]))
        voltage: float = self._compiled.voltage_mv(self._state, self._queue, t_ms)
        return voltage

    def state(self) -> tuple[float, float, float, float, list[tuple[float, float]]]:
        """Return the state for a snapshot."""
        at_ms, current, slope, above = (self._state[name].item() for name in _CHANGING)
        times, weights = self._queue[:, : self._state["waiting"][0]].tolist()
        return at_ms, current, slope, above, list(zip(times, weights, strict=True))

    def restore(self, state: tuple[float, float, float, float, list[tuple[float, float]]]) -> None:
        """Restore a state."""
        *changing, pending = state
        for name, value in zip(_CHANGING, changing, strict=True):
            self._state[name] = value
        self._state["waiting"] = 0
        self.push(*np.reshape(pending, (-1, 2)).T)
