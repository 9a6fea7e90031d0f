"""Short-term plasticity of Tsodyks, Uziel & Markram (2000, J Neurosci 20:RC50), PyNN's TsodyksMarkramSynapse.

Of a synapse's resources the share x is recovered, y active and z inactive; y decays into z with the
time constant of the target's synapse, z recovers with ``tau_rec``. A spike first lets u jump by
``U (1 - u)`` (u decays with ``tau_facil``; without facilitation it is U), then releases u x: the spike
arrives with the weight times u x. So the first spike from rest arrives with U times the weight.
"""

from __future__ import annotations

from math import exp

from nrp_brain_event.records import ShortTerm
from nrp_brain_event.synapses import driven
from nrp_core.jit import jit


@jit
def released_share(synapse: ShortTerm, t: float) -> float:
    """Return the share of the weight with which a spike emitted at t arrives, and use it up."""
    dt = t - synapse.t
    if synapse.tau_psc > 0.0:
        recovery, decay = exp(-dt / synapse.tau_rec), exp(-dt / synapse.tau_psc)
        gap = 1.0 / synapse.tau_psc - 1.0 / synapse.tau_rec
        inflow = driven(dt, recovery, decay, gap, synapse.y / synapse.tau_psc, 0.0)
        synapse.z = synapse.z * recovery + inflow
        synapse.y *= decay
    else:  # nothing stays active on a target whose synapses are jumps
        synapse.z = (synapse.z + synapse.y) * exp(-dt / synapse.tau_rec)
        synapse.y = 0.0
    facilitated = synapse.u * exp(-dt / synapse.tau_facil) if synapse.tau_facil > 0.0 else 0.0
    synapse.u = facilitated + synapse.U * (1.0 - facilitated)
    released = synapse.u * (1.0 - synapse.y - synapse.z)
    synapse.y += released
    synapse.t = t
    return released
