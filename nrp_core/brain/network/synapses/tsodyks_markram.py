"""Short-term plasticity of Tsodyks, Uziel & Markram (2000, J Neurosci 20:RC50).

The fraction x of a synapse's resources is recovered, y active and z inactive; y decays into z with the
time constant of the target's synapse, z recovers with ``tau_rec``. A spike first lets u jump by
``U (1 - u)`` (u decays with ``tau_facil``; without facilitation it is U), then releases u x: the spike
arrives with the weight times u x. So the first spike from rest arrives with U times the weight.
"""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.parameters import FRACTION, NOT_NEGATIVE_OR_INFINITE, POSITIVE, Parameter
from nrp_core.brain.network.synapses.law import SynapseLaw

TSODYKS_MARKRAM: Final = "tsodyks_markram"

LAW: Final = SynapseLaw(
    TSODYKS_MARKRAM,
    pynn="TsodyksMarkramSynapse",
    summary="A synapse with depression (``U``, ``tau_rec``) and facilitation (``tau_facil``); times in ms.",
    parameters={
        "U": Parameter(0.5, limit=FRACTION),
        "tau_rec": Parameter(100.0, "ms", POSITIVE),
        "tau_facil": Parameter(0.0, "ms", NOT_NEGATIVE_OR_INFINITE),
    },
    state={name: Parameter(0.0, limit=FRACTION) for name in ("u", "y", "z")},
    shares=("y", "z"),
)
