"""Synapses with a constant weight."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.synapses.law import SynapseLaw

STATIC: Final = "static"

LAW: Final = SynapseLaw(
    STATIC,
    pynn="StaticSynapse",
    summary="A constant weight and delay (ms).",
    stands_for=("ElectricalSynapse",),
)
