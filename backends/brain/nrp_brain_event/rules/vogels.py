"""PyNN's Vogels2011Rule over all pairs (Vogels et al. 2011, Science 334:1569).

Each pair of spikes at a distance dt, in any order, adds ``eta exp(-dt / tau)``; each spike of the source
takes away ``2 eta rho tau``. A simultaneous pair counts once.
"""

from __future__ import annotations

from math import exp
from typing import Any

from nrp_brain_event.rules.weights import change
from nrp_core._support.jit import jit
from nrp_core.clock import MS_PER_S


@jit
def on_source(rule: Any, synapse: Any, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its target, and depress it by a constant."""
    near = (synapse.post_trace + 1.0) * exp((synapse.post_t - t) / rule.tau)
    change(rule, synapse, rule.eta * (near - 2.0 * rule.rho * rule.tau / MS_PER_S), 1.0)
    synapse.pre_trace = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau)
    synapse.pre_t = t


@jit
def on_target(rule: Any, synapse: Any, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its source."""
    near = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau)
    change(rule, synapse, rule.eta * near, 1.0)
    synapse.post_trace = (synapse.post_trace + 1.0) * exp((synapse.post_t - t) / rule.tau)
    synapse.post_t = t
