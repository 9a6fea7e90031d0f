"""The kernels of all synapses whose law is given as equations: they call that of the synapse."""

from __future__ import annotations

from typing import Any

from nrp_brain_event.addresses import call
from nrp_core._support.jit import jit


@jit
def strength(synapse: Any, t: float) -> float:
    """Return the share of the weight with which a spike emitted at t (ms) arrives, and update the synapse."""
    call(synapse.own, (synapse, t))
    return float(synapse.share)


@jit
def on_source(rule: Any, synapse: Any, t: float) -> None:
    """Update a synapse for a spike of its source."""
    call(rule.own, (rule, synapse, t, 0))


@jit
def on_target(rule: Any, synapse: Any, t: float) -> None:
    """Update a synapse for a spike of its target."""
    call(rule.own, (rule, synapse, t, 1))
