"""Every synapse law; limits, PyNN's classes, file readers and conformance tests follow this table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nrp_core.brain.network.synapses import static, stdp, tsodyks_markram
from nrp_core.brain.network.synapses.law import SynapseLaw

LAWS: Final[Mapping[str, SynapseLaw]] = {
    law.name: law
    for law in (
        static.LAW,
        tsodyks_markram.LAW,
        stdp.LAW,
    )
}
