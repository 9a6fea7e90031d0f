"""Exact linear filters of spike trains, used by the leaky integrators and the population rate.

The membrane of a neuron that never fires, driven by exponential or alpha-shaped currents, is a linear
system with a closed solution between events (Rotter & Diesmann 1999, Biological Cybernetics 81:381).
The state is kept at the last event; reading never changes it, so the numbers do not depend on
the number of reads or on how a run is split.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import e, exp, inf


@dataclass(frozen=True, slots=True)
class MembraneKernel:
    """A leaky membrane with one synaptic current.

    ``dV/dt = -(V - v_rest)/tau_m + (I + i_offset)/cm``, and a spike of weight ``w`` adds
    ``w exp(-t/tau_syn)`` (exp) or ``w (e/tau_syn) t exp(-t/tau_syn)`` (alpha, peak ``w``) to ``I``.

    Args:
        alpha: alpha-shaped current, else exponential.
        tau_m_ms, tau_syn_ms: time constants.
        cm_nf: capacitance.
        v_rest_mv: resting voltage.
        i_offset_na: constant current.
    """

    alpha: bool
    tau_m_ms: float
    tau_syn_ms: float
    cm_nf: float = 1.0
    v_rest_mv: float = 0.0
    i_offset_na: float = 0.0

    @property
    def settled_mv(self) -> float:
        """Steady-state voltage without spikes."""
        return self.v_rest_mv + self.i_offset_na * self.tau_m_ms / self.cm_nf

    @property
    def area(self) -> float:
        """Integral over time of the voltage that a spike of weight 1 nA adds, in mV ms."""
        charge = self.tau_syn_ms * (e if self.alpha else 1.0)
        return charge * self.tau_m_ms / self.cm_nf


def driven(dt: float, leak: float, fade: float, gap: float, current: float, slope: float) -> float:
    """Return a leaky integrator's response to the current ``(current + slope t) exp(-t/tau_syn)``.

    That is the integral of the current times ``exp(-(dt - t)/tau_m)`` over t in 0..dt, for any time
    constants, equal ones included.

    Args:
        dt: elapsed time.
        leak: ``exp(-dt/tau_m)``.
        fade: ``exp(-dt/tau_syn)``.
        gap: ``1/tau_syn - 1/tau_m``.
        current: the current at the beginning.
        slope: its growth rate without the decay.
    """
    z = gap * dt
    if abs(z) > 0.02:
        area = (leak - fade) / gap
        return current * area if slope == 0.0 else current * area + slope * (area - dt * fade) / gap
    # The closed form loses digits here; the series expansion of its integrals is exact to rounding.
    area = 1 - z / 2 * (1 - z / 3 * (1 - z / 4 * (1 - z / 5 * (1 - z / 6 * (1 - z / 7)))))
    if slope == 0.0:
        return leak * dt * current * area
    second = 1 / 2 - z * (1 / 3 - z * (1 / 8 - z * (1 / 30 - z * (1 / 144 - z * (1 / 840 - z / 5760)))))
    return leak * dt * (current * area + slope * dt * second)


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
        self._pending: list[tuple[float, float]] = []
        self._last_read: tuple[float, float] | None = None

    def push(self, train: Iterable[tuple[float, float]]) -> None:
        """Add spikes: their arrival times, ms, and their weights, nA."""
        self._pending.extend(train)
        self._last_read = None

    def voltage_mv(self, t_ms: float) -> float:
        """Return the voltage at ``t_ms``, including all spikes that have arrived by then."""
        if self._last_read is not None and self._last_read[0] == t_ms:
            return self._last_read[1]  # a transfer function and a recording may both read it
        if self._pending:
            self._pending.sort()
            arrived = bisect_right(self._pending, (t_ms, inf))
            self._take(self._pending[:arrived])
            del self._pending[:arrived]
        dt_ms = t_ms - self._at_ms
        fade, leak = exp(-dt_ms / self._tau_syn_ms), exp(-dt_ms / self._tau_m_ms)
        charge = driven(dt_ms, leak, fade, self._gap, self._current, self._slope)
        voltage = self._settled_mv + (self._above * leak + charge / self._cm_nf)
        self._last_read = t_ms, voltage
        return voltage

    def _take(self, train: Sequence[tuple[float, float]]) -> None:
        """Move to each spike and add it; on local names, since there are many."""
        tau_m_ms, tau_syn_ms, cm_nf, gap = self._tau_m_ms, self._tau_syn_ms, self._cm_nf, self._gap
        at_ms, current, slope, above = self._at_ms, self._current, self._slope, self._above
        for arrival_ms, weight in train:
            dt_ms = arrival_ms - at_ms
            fade, leak = exp(-dt_ms / tau_syn_ms), exp(-dt_ms / tau_m_ms)
            above = above * leak + driven(dt_ms, leak, fade, gap, current, slope) / cm_nf
            current = (current + slope * dt_ms) * fade
            slope *= fade
            if self._alpha:
                slope += weight * e / tau_syn_ms
            else:
                current += weight
            at_ms = arrival_ms
        self._at_ms, self._current, self._slope, self._above = at_ms, current, slope, above

    def state(self) -> tuple[float, float, float, float, list[tuple[float, float]]]:
        """Return the state for a snapshot."""
        return self._at_ms, self._current, self._slope, self._above, list(self._pending)

    def restore(self, state: tuple[float, float, float, float, list[tuple[float, float]]]) -> None:
        """Restore a state."""
        self._at_ms, self._current, self._slope, self._above, pending = state
        self._pending = list(pending)
        self._last_read = None
