"""Short-term plasticity of several release sites, each with one quantum.

The law is that of Loebel et al. (2009, Front Comput Neurosci 3:27), as PyNN has it in NEURON: a spike
releases each of the filled sites with the probability u, and arrives with the share of the ``n`` sites that
released; an empty site is filled again at the rate ``1 / tau_rec``. A spike lets u jump by ``U (1 - u)``;
between spikes u decays with ``tau_facil``. PyNN's initial value ``a`` is the number of filled sites.
"""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.parameters import FRACTION, NOT_NEGATIVE, WHOLE, Parameter
from nrp_core.brain.network.synapses import tsodyks_markram
from nrp_core.brain.network.synapses.law import SynapseLaw

MULTIQUANTAL: Final = "multiquantal"
_SHARED: Final = tsodyks_markram.LAW.parameters

LAW: Final = SynapseLaw(
    MULTIQUANTAL,
    pynn="MultiQuantalSynapse",
    summary="Depression and facilitation of ``n`` sites, each of which a spike empties or not; times in ms.",
    parameters={
        **_SHARED,
        "tau_rec": Parameter(800.0, _SHARED["tau_rec"].unit, _SHARED["tau_rec"].limit),
        "n": Parameter(1.0, limit=WHOLE),
    },
    state={"u": Parameter(0.0, limit=FRACTION), "empty": Parameter(0.0, limit=NOT_NEGATIVE)},
    complements={"a": ("empty", "n")},
)
