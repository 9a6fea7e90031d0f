"""The membrane of a neuron that never fires, under the spikes that arrive at it.

The state is kept at the last event; reading never changes it, so the numbers do not depend on the number of
reads or on how a run is split.
"""

from __future__ import annotations

from math import e, exp
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.network.filters import MembraneKernel, driven

_MANY: Final = 6
"""Spikes that compiled code passes faster, with the same result."""


class LeakyMembrane:
    """The state of a :class:`MembraneKernel` under a train of weighted spikes.

    Spikes are pushed with their arrival times, in any order not before the last read; a read at ``t``
    sees those that arrived at or before ``t``.
    """

    def __init__(self, kernel: MembraneKernel) -> None:
        self._alpha, self._cm_nf, self._settled_mv = kernel.alpha, kernel.cm_nf, kernel.settled_mv
        self._tau_m_ms, self._tau_syn_ms = kernel.tau_m_ms, kernel.tau_syn_ms
        self._gap = 1.0 / kernel.tau_syn_ms - 1.0 / kernel.tau_m_ms
        self._at_ms = 0.0
        self._current = 0.0
        self._slope = 0.0
        self._above = kernel.v_rest_mv - kernel.settled_mv
        self._pending: list[tuple[FloatArray, FloatArray]] = []
        self._last_read: tuple[float, float] | None = None

    def push(self, arrivals_ms: npt.ArrayLike, weights: npt.ArrayLike) -> None:
        """Add spikes: arrival times, ms, and weights, nA, shape ``(n,)``; arrays may be sorted in place."""
        self._pending.append((np.asarray(arrivals_ms, float), np.asarray(weights, float)))
        self._last_read = None

    def voltage_mv(self, t_ms: float) -> float:
        """Return the voltage at ``t_ms``, including all spikes that have arrived by then."""
        if self._last_read is not None and self._last_read[0] == t_ms:
            return self._last_read[1]  # a transfer function and a recording may both read it
        if self._pending:
            self._take(t_ms)
        dt_ms = t_ms - self._at_ms
        fade, leak = exp(-dt_ms / self._tau_syn_ms), exp(-dt_ms / self._tau_m_ms)
        charge = driven(dt_ms, leak, fade, self._gap, self._current, self._slope)
        voltage = self._settled_mv + (self._above * leak + charge / self._cm_nf)
        self._last_read = t_ms, voltage
        return voltage

    def _take(self, t_ms: float) -> None:
        """Move to each spike that has arrived, and add it."""
        arrivals_ms, weights = self._pending[0]
        if len(self._pending) > 1:
            arrivals_ms, weights = map(np.concatenate, zip(*self._pending, strict=True))
        self._pending.clear()
        if len(arrivals_ms) < _MANY:
            arrived = self._pass(arrivals_ms, weights, t_ms)
        else:
            from nrp_core.brain.devices.membrane_kernel import pass_spikes

            state = np.array([self._at_ms, self._current, self._slope, self._above])
            constants = (self._alpha, self._tau_m_ms, self._tau_syn_ms, self._cm_nf)
            arrived = pass_spikes(state, arrivals_ms, weights, t_ms, *constants)
            self._at_ms, self._current, self._slope, self._above = state.tolist()
        if arrived < len(arrivals_ms):
            self._pending.append((arrivals_ms[arrived:], weights[arrived:]))

    def _pass(self, arrivals_ms: FloatArray, weights: FloatArray, t_ms: float) -> int:
        """Sort a few spikes in place, pass those that have arrived, and return their number."""
        if len(arrivals_ms) > 1:
            order = np.lexsort((weights, arrivals_ms))
            arrivals_ms[:], weights[:] = arrivals_ms[order], weights[order]
        arrived = 0
        for arrival_ms, weight in zip(arrivals_ms.tolist(), weights.tolist(), strict=True):
            if arrival_ms > t_ms:
                break
            dt_ms = arrival_ms - self._at_ms
            fade, leak = exp(-dt_ms / self._tau_syn_ms), exp(-dt_ms / self._tau_m_ms)
            charge = driven(dt_ms, leak, fade, self._gap, self._current, self._slope)
            self._above = self._above * leak + charge / self._cm_nf
            self._current = (self._current + self._slope * dt_ms) * fade
            self._slope *= fade
            if self._alpha:
                self._slope += weight * e / self._tau_syn_ms
            else:
                self._current += weight
            self._at_ms = arrival_ms
            arrived += 1
        return arrived

    def state(self) -> tuple[float, float, float, float, list[tuple[float, float]]]:
        """Return the state for a snapshot."""
        pairs = (zip(arrivals.tolist(), weights.tolist(), strict=True) for arrivals, weights in self._pending)
        pending = [pair for train in pairs for pair in train]
        return self._at_ms, self._current, self._slope, self._above, pending

    def restore(self, state: tuple[float, float, float, float, list[tuple[float, float]]]) -> None:
        """Restore a state."""
        self._at_ms, self._current, self._slope, self._above, pending = state
        self._pending.clear()
        if pending:
            self.push(*zip(*pending, strict=True))
        self._last_read = None
