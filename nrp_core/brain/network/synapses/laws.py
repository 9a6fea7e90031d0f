"""Every synapse law; limits, PyNN's classes, file readers and conformance tests follow this table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nrp_core.brain.network.synapses import (
    multiquantal,
    simple_stochastic,
    static,
    stdp,
    stochastic_tsodyks_markram,
    tsodyks_markram,
)
from nrp_core.brain.network.synapses.law import SynapseLaw

LAWS: Final[Mapping[str, SynapseLaw]] = {
    law.name: law
    for law in (
        static.LAW,
        tsodyks_markram.LAW,
        simple_stochastic.LAW,
        stochastic_tsodyks_markram.LAW,
        multiquantal.LAW,
        stdp.LAW,
    )
}
PLASTIC: Final = frozenset(law.name for law in LAWS.values() if law.plastic)
"""The laws whose weights change by themselves."""
