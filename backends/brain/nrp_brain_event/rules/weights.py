"""What the rules share: traces of spikes, and how a weight limits its own change.

A change is a share of ``w_max (d / w_max)^mu``, where d is the distance of the weight from the limit:
``w_max`` itself for mu = 0 (additive), d for mu = 1 (multiplicative; Morrison, Diesmann & Gerstner 2008, Biol
Cybern 98:459), and powers between (Gütig et al. 2003, J Neurosci 23:3697).
"""

from __future__ import annotations

from math import exp
from typing import Any, Final

from nrp_core._support.jit import jit

SIMULTANEOUS: Final = 1e-9
"""Tolerance of equal times in floating point, ms."""


@jit
def trace(last: float, before: float, t: float, tau: float) -> float:
    """Return the trace at t of a train of spikes, each with amplitude 1; a spike at t does not count.

    Args:
        last: time of the last spike.
        before: the trace of the earlier spikes then.
        t: not before the last spike.
        tau: time constant.
    """
    if t - last <= SIMULTANEOUS:
        return before
    return (before + 1.0) * exp((last - t) / tau)


@jit
def span_up(rule: Any, synapse: Any) -> float:
    """Return the amount of which an increase is a share."""
    return _span(rule.w_max - synapse.weight, rule.mu_plus, rule.w_max)


@jit
def span_down(rule: Any, synapse: Any) -> float:
    """Return the amount of which a decrease is a share."""
    return _span(synapse.weight - rule.w_min, rule.mu_minus, rule.w_max)


@jit
def _span(distance: float, mu: float, largest: float) -> float:
    if mu == 0.0:
        return largest
    if mu == 1.0:
        return distance
    return float(largest * (max(distance, 0.0) / largest) ** mu)


@jit
def change(rule: Any, synapse: Any, share: float, span: float) -> None:
    """Change the weight by a share of ``span``, clipped at the limit in the direction of the share."""
    if share > 0.0:
        synapse.weight = min(synapse.weight + share * span, rule.w_max)
    elif share < 0.0:
        synapse.weight = max(synapse.weight + share * span, rule.w_min)
