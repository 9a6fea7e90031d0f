"""The synapse laws that the engine runs; importing this loads no compiler.

A law whose spikes arrive with a share of the weight is one entry in :data:`SHARES`: its kernel gets the
record of a synapse and the time of a spike (ms), returns the share, and brings the record up to date.
The record holds the law's parameters and state, ``tau_psc`` (time constant of the target's synapse, ms, 0
where nothing stays active) and ``t`` (the last spike, ms; 0 at first).
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
    from nrp_core.brain.network.synapses.short_term import released_share

    return released_share


SHARES: Final[Mapping[str, Callable[[], Share]]] = {
    TSODYKS_MARKRAM: _tsodyks_markram,
}
"""What loads the kernel of each law."""

SYNAPSES: Final = frozenset({STATIC, STDP, *SHARES})


def fields_of(names: Mapping[str, object]) -> list[tuple[str, str]]:
    """Return the fields of a record that any of these laws can use; ``law`` says which, if there are two."""
    laws = [LAWS[name] for name in names]
    parameters = [name for law in laws for name in law.parameters]
    state = [name for law in laws for name in law.state]
    numbers = dict.fromkeys([*parameters, "tau_psc", "t", *state])
    return [*((name, "f8") for name in numbers), *([("law", "i8")] if len(laws) > 1 else [])]
