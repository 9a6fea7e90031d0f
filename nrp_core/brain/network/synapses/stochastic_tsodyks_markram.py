"""Short-term plasticity in the stochastic form of Fuhrmann et al. (2002, J Neurophysiol 87:140).

One vesicle is there, or not; a spike releases it with the probability u of the deterministic law
(:mod:`nrp_core.brain.network.synapses.tsodyks_markram`) and then arrives with the whole weight. A released
vesicle comes back at the rate ``1 / tau_rec``.
"""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.parameters import FRACTION, Parameter
from nrp_core.brain.network.synapses import tsodyks_markram
from nrp_core.brain.network.synapses.law import SynapseLaw

STOCHASTIC_TSODYKS_MARKRAM: Final = "stochastic_tsodyks_markram"

LAW: Final = SynapseLaw(
    STOCHASTIC_TSODYKS_MARKRAM,
    pynn="StochasticTsodyksMarkramSynapse",
    summary="Depression and facilitation of one vesicle that a spike releases or not; times in ms.",
    parameters=tsodyks_markram.LAW.parameters,
    state={name: Parameter(0.0, limit=FRACTION) for name in ("u", "empty")},
)
