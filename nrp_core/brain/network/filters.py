"""Exact linear filters of spike trains, used by the leaky integrators and the population rate.

The membrane of a neuron that never fires, driven by exponential or alpha-shaped currents, is a linear
system with a closed solution between events (Rotter & Diesmann 1999, Biological Cybernetics 81:381).
The state is kept at the last event; reading never changes it, so the numbers do not depend on
the number of reads or on how a run is split.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from math import e, exp


@dataclass(frozen=True, slots=True)
class Kernel:
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
    """The state of a :class:`Kernel` under a train of weighted spikes.

    Spikes are pushed with their arrival times, in any order not before the last read; a read at ``t``
    sees those that arrived at or before ``t``.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._alpha, self._cm_nf, self._settled_mv = kernel.alpha, kernel.cm_nf, kernel.settled_mv
        self._tau_m_ms, self._tau_syn_ms = kernel.tau_m_ms, kernel.tau_syn_ms
        self._gap = 1.0 / kernel.tau_syn_ms - 1.0 / kernel.tau_m_ms
        self._at_ms = 0.0
        self._current = 0.0
        self._slope = 0.0
        self._above = kernel.v_rest_mv - kernel.settled_mv
        self._pending: list[tuple[float, float]] = []
        self._last_read: tuple[float, float] | None = None

    def push(self, arrival_ms: float, weight_na: float) -> None:
        """Add a weighted spike that arrives at ``arrival_ms``."""
        heapq.heappush(self._pending, (arrival_ms, weight_na))
        self._last_read = None

    def voltage_mv(self, t_ms: float) -> float:
        """Return the voltage at ``t_ms``, including all spikes that have arrived by then."""
        if self._last_read is not None and self._last_read[0] == t_ms:
            return self._last_read[1]  # a transfer function and a recording may both read it
        while self._pending and self._pending[0][0] <= t_ms:
            arrival_ms, weight = heapq.heappop(self._pending)
            self._move_to(arrival_ms)
            if self._alpha:
                self._slope += weight * e / self._tau_syn_ms
            else:
                self._current += weight
        dt_ms = t_ms - self._at_ms
        voltage = self._settled_mv + self._above_at(dt_ms, exp(-dt_ms / self._tau_syn_ms))
        self._last_read = t_ms, voltage
        return voltage

    def _above_at(self, dt_ms: float, fade: float) -> float:
        """Voltage above its steady state after ``dt_ms``; ``fade`` is the decay of the current."""
        leak = exp(-dt_ms / self._tau_m_ms)
        charge = driven(dt_ms, leak, fade, self._gap, self._current, self._slope)
        return self._above * leak + charge / self._cm_nf

    def _move_to(self, t_ms: float) -> None:
        dt_ms = t_ms - self._at_ms
        fade = exp(-dt_ms / self._tau_syn_ms)
        self._above = self._above_at(dt_ms, fade)
        self._current = (self._current + self._slope * dt_ms) * fade
        self._slope *= fade
        self._at_ms = t_ms

    def state(self) -> tuple[float, float, float, float, list[tuple[float, float]]]:
        """Return the state for a snapshot."""
        return self._at_ms, self._current, self._slope, self._above, list(self._pending)

    def restore(self, state: tuple[float, float, float, float, list[tuple[float, float]]]) -> None:
        """Restore a state."""
        self._at_ms, self._current, self._slope, self._above, pending = state
        self._pending = list(pending)
        self._last_read = None
