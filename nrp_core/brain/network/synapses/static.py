"""Synapses whose weight stays what it is."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.synapses.law import SynapseLaw

STATIC: Final = "static"

LAW: Final = SynapseLaw(
    STATIC,
    pynn="StaticSynapse",
    summary="A weight and a delay (ms) that stay.",
    stands_for=("SimpleStochasticSynapse", "ElectricalSynapse"),
)
