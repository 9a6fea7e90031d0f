"""The synapse laws that the engine runs. Importing this does not load a compiler.

A law whose spikes transmit a fraction of the weight is one entry in :data:`SHARES`: its kernel gets the
record of a synapse and the time of a spike (ms), returns the fraction, and updates the record.
The record holds the law's parameters and state, ``tau_psc`` (time constant of the target's synapse, ms, 0 for
a delta synapse) and ``t`` (the last spike, ms; 0 at first).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from nrp_core.brain.network.synapses.laws import LAWS
from nrp_core.brain.network.synapses.static import STATIC
from nrp_core.brain.network.synapses.stdp import STDP
from nrp_core.brain.network.synapses.tsodyks_markram import TSODYKS_MARKRAM

Share = Callable[[Any, float], float]


def _tsodyks_markram() -> Share:
    from nrp_core.brain.network.synapses.tsodyks_markram_kernel import released_share

    return released_share


SHARES: Final[Mapping[str, Callable[[], Share]]] = {
    TSODYKS_MARKRAM: _tsodyks_markram,
}
"""The loader of each law's kernel."""

SYNAPSES: Final = frozenset({STATIC, STDP, *SHARES})


def fields_of(names: Mapping[str, object]) -> list[tuple[str, str]]:
    """Return the fields of a record for all of these laws; ``law`` selects one, if there are two or more."""
    laws = [LAWS[name] for name in names]
    parameters = [name for law in laws for name in law.parameters]
    state = [name for law in laws for name in law.state]
    numbers = dict.fromkeys([*parameters, "tau_psc", "t", *state])
    return [*((name, "f8") for name in numbers), *([("law", "i8")] if len(laws) > 1 else [])]
