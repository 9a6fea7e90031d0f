"""Synapses that transmit each spike with a fixed probability."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.parameters import FRACTION, Parameter
from nrp_core.brain.network.synapses.law import SynapseLaw

SIMPLE_STOCHASTIC: Final = "simple_stochastic"

LAW: Final = SynapseLaw(
    SIMPLE_STOCHASTIC,
    pynn="SimpleStochasticSynapse",
    summary="Each spike is transmitted with the probability ``p``.",
    parameters={"p": Parameter(0.5, limit=FRACTION)},
)
