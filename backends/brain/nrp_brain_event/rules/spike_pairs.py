"""PyNN's SpikePairRule over all pairs.

For two spikes at a distance dt the later one changes the weight, by

- ``A_plus f exp(-dt / tau_plus)`` upwards if the target's came later,
- ``A_minus f exp(-dt / tau_minus)`` downwards if it came first (a negative A has the opposite effect),

with f as in :mod:`nrp_brain_event.rules.weights`. Simultaneous spikes have no effect.
"""

from __future__ import annotations

from math import exp
from typing import Any

from nrp_brain_event.rules.weights import change, span_down, span_up, trace
from nrp_core._support.jit import jit


@jit
def on_source(rule: Any, synapse: Any, t: float) -> None:
    """Depress the synapse by the earlier spikes of its target."""
    depression = rule.A_minus * trace(synapse.post_t, synapse.post_trace, t, rule.tau_minus)
    change(rule, synapse, -depression, span_down(rule, synapse))
    synapse.pre_trace = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau_plus)
    synapse.pre_t = t


@jit
def on_target(rule: Any, synapse: Any, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its source."""
    potentiation = rule.A_plus * trace(synapse.pre_t, synapse.pre_trace, t, rule.tau_plus)
    change(rule, synapse, potentiation, span_up(rule, synapse))
    synapse.post_trace = (synapse.post_trace + 1.0) * exp((synapse.post_t - t) / rule.tau_minus)
    synapse.post_t = t
