"""Exact linear filters of spike trains, used by the leaky integrators and the population rate.

The membrane of a neuron that never fires, driven by exponential or alpha-shaped currents, is a linear
system with a closed solution between events (Rotter & Diesmann 1999, Biological Cybernetics 81:381).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import e


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
