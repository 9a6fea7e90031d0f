"""The membrane of a neuron that never fires and receives spikes.

The state is kept at the last event; reading never changes the voltage, so the numbers do not depend on the
number of reads or on how a run is split.
"""

from __future__ import annotations

from math import exp
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray, address
from nrp_core.brain.devices.records import CHANGING, CONSTANTS, MEMBRANE
from nrp_core.network.filters import MembraneKernel

_ROOM: Final = 8


class LeakyMembrane:
    """The state of a :class:`MembraneKernel` under a train of weighted spikes.

    Spikes are added with their arrival times, in any order but not before the last read. A read at ``t`` sees
    those that arrived at or before ``t``.

    Attributes:
        record: the state, an array of one record.
        place: its address.
    """

    def __init__(self, kernel: MembraneKernel) -> None:
        self.record = np.zeros(1, MEMBRANE)
        self.place = address(self.record)
        for name in CONSTANTS:
            self.record[name] = getattr(kernel, name)
        self._above_mv = kernel.v_rest_mv - kernel.settled_mv
        self._compiled: Any = None  # loaded at the first spike
        self._set_queue(np.empty((2, _ROOM)))
        self.reset()

    def connect(self, weights: FloatArray, received: npt.NDArray[np.bool_], delay_ms: float) -> None:
        """Set the weight (nA) of each neuron, whether its spikes are received, and the delay of all."""
        self._weights, self._received = weights, received  # the record keeps only their addresses
        self.record["weights"], self.record["received"] = address(weights), address(received)
        self.record["n_neurons"], self.record["delay_ms"] = len(weights), delay_ms

    def reset(self) -> None:
        """Return to the state at time 0."""
        for name in (*CHANGING, "waiting", "now_ms"):
            self.record[name] = 0
        self.record["above"] = self._above_mv

    def push(self, arrivals_ms: npt.ArrayLike, weights: npt.ArrayLike) -> None:
        """Add spikes: arrival times, ms, and weights, nA, shape ``(n,)``."""
        first, times = self.record["waiting"].item(0), np.asarray(arrivals_ms, float)
        last = first + len(times)
        while last > self._queue.shape[1]:
            self.grow()
        self._queue[0, first:last], self._queue[1, first:last] = times, weights
        self.record["waiting"] = last
        self._load()

    def receive(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Add the spikes that the membrane receives, given the neuron and the time (ms) of each spike."""
        while not self._load().enqueue(self.place, neurons, times_ms):
            self.grow()

    def grow(self) -> None:
        """Make room for twice as many waiting spikes."""
        room = np.empty((2, 2 * self._queue.shape[1]))
        room[:, : self._queue.shape[1]] = self._queue
        self._set_queue(room)

    def place_for_spikes(self) -> int:
        """Return the address of the record for compiled code, which may add spikes from then on."""
        self._load()
        return self.place

    def _set_queue(self, queue: FloatArray) -> None:
        self._queue = queue
        self.record["queue"], self.record["room"] = address(queue), queue.shape[1]

    def _load(self) -> Any:
        if self._compiled is None:
            from nrp_core.brain.devices import membrane_kernel

            self._compiled = membrane_kernel
        return self._compiled

    def voltage_mv(self, t_ms: float) -> float:
        """Return the voltage at ``t_ms``, including all spikes that have arrived by then."""
        if self._compiled is None:
            rest = self.record[0]
            return float(rest["settled_mv"] + rest["above"] * exp(-t_ms / rest["tau_m_ms"]))
        voltage: float = self._compiled.voltage_mv(self.place, t_ms)
        return voltage

    def state(self) -> tuple[float, float, float, float, list[tuple[float, float]]]:
        """Return the state for a snapshot."""
        at_ms, current, slope, above = (self.record[name].item() for name in CHANGING)
        times, weights = self._queue[:, : self.record["waiting"][0]].tolist()
        return at_ms, current, slope, above, list(zip(times, weights, strict=True))

    def restore(self, state: tuple[float, float, float, float, list[tuple[float, float]]]) -> None:
        """Restore a state."""
        *changing, pending = state
        for name, value in zip(CHANGING, changing, strict=True):
            self.record[name] = value
        self.record["waiting"] = 0
        self.push(*np.reshape(pending, (-1, 2)).T)
