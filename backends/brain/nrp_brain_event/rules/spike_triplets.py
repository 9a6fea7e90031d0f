"""The triplet rule of Pfister & Gerstner (2006, J Neurosci 26:9673), all to all, with additive weights.

With the traces r1 (``tau_plus``) and r2 (``tau_x``) of the source's spikes, and o1 (``tau_minus``) and o2
(``tau_y``) of the target's, a spike of the target adds ``w_max r1 (A_plus + A3_plus o2)``, and one of the
source takes away ``w_max o1 (A_minus + A3_minus r2)``. All traces are those before the spike; simultaneous
spikes have no effect on each other.
"""

from __future__ import annotations

from math import exp
from typing import Any

from nrp_brain_event.rules.weights import change, trace
from nrp_core._support.jit import jit


@jit
def on_source(rule: Any, synapse: Any, t: float) -> None:
    """Depress the synapse by the earlier spikes of its target, more after earlier ones of its source."""
    own = trace(synapse.pre_t, synapse.pre_slow, t, rule.tau_x)
    of_target = trace(synapse.post_t, synapse.post_trace, t, rule.tau_minus)
    change(rule, synapse, -of_target * (rule.A_minus + rule.A3_minus * own), rule.w_max)
    passed = exp((synapse.pre_t - t) / rule.tau_plus)
    synapse.pre_trace, synapse.pre_slow, synapse.pre_t = (synapse.pre_trace + 1.0) * passed, own, t


@jit
def on_target(rule: Any, synapse: Any, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its source, more after earlier ones of its target."""
    own = trace(synapse.post_t, synapse.post_slow, t, rule.tau_y)
    of_source = trace(synapse.pre_t, synapse.pre_trace, t, rule.tau_plus)
    change(rule, synapse, of_source * (rule.A_plus + rule.A3_plus * own), rule.w_max)
    passed = exp((synapse.post_t - t) / rule.tau_minus)
    synapse.post_trace, synapse.post_slow, synapse.post_t = (synapse.post_trace + 1.0) * passed, own, t
