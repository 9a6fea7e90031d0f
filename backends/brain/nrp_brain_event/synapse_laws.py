"""The synapse laws that the engine runs. Importing this does not load a compiler.

A law whose spikes transmit a fraction of the weight is one entry in :data:`SHARES`: its kernel gets the
record of a synapse and the time of a spike (ms), returns the fraction, and updates the record. The record
holds the law's parameters and state, ``tau_psc`` (time constant of the target's synapse, ms, 0 for a delta
synapse) and ``t`` (the last spike, ms; 0 at first). A
kernel that draws calls :func:`nrp_brain_event.random_numbers.uniform` with the record.

A law whose spikes change the weight is one entry in :data:`RULES`, by its own name or by that of its part
that distinguishes it. A law in equations is an entry in both, since its kernel is written for it.
The kernels are in :mod:`nrp_brain_event.synapse_kernels`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from nrp_core.network.equations.synapse import SYNAPSE_TYPE
from nrp_core.network.synapses import (
    LAWS,
    MULTIQUANTAL,
    PLASTIC,
    SIMPLE_STOCHASTIC,
    STATIC,
    STOCHASTIC_TSODYKS_MARKRAM,
    TSODYKS_MARKRAM,
    SynapseLaw,
)

SHARES: Final = (
    TSODYKS_MARKRAM,
    SIMPLE_STOCHASTIC,
    STOCHASTIC_TSODYKS_MARKRAM,
    MULTIQUANTAL,
    SYNAPSE_TYPE,
)
"""The laws whose spikes transmit a share of the weight."""

NEUROMODULATED: Final = "Neuromodulation"
"""The rule of synapses with STDP onto cells that receive rewards; see :mod:`nrp_brain_event.rewards`."""
RULES: Final = ("SpikePairRule", "Vogels2011Rule", "PfisterSpikeTripletRule", SYNAPSE_TYPE, NEUROMODULATED)
"""The rules of plasticity."""

SYNAPSES: Final = frozenset(
    {
        STATIC,
        *SHARES,
        *(
            name
            for name in PLASTIC
            if {*RULES} & {name, *(one for of in LAWS[name].parts.values() for one in of)}
        ),
    }
)


_OWN_FIELDS: Final = (("own", "i8"), ("share", "f8"), ("free", "f8"))


def share_fields(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return the fields of a record for all of these laws; ``law`` selects one, if there are two or more.

    Laws given as equations use the fields of the others, and three of their own: the kernel, the share, and
    one that makes a record two cache lines long.
    """
    laws = [LAWS[name] for name in names if name in LAWS]
    # what the first law uses lies together: a record is longer than a cache line
    numbers = dict.fromkeys(["tau_psc", "t", *_parameters(laws[:1]), *_state(laws)])
    numbers |= dict.fromkeys(_parameters(laws))
    law = [("law", "i8")] if len(laws) > 1 else []
    return [*law, *((name, "f8") for name in numbers), ("stream", "i8"), *_OWN_FIELDS]


def rule_fields() -> list[tuple[str, str]]:
    """Return the fields of the parameters of all plastic laws, of a kernel and of where it finds dopamine."""
    numbers = _parameters([LAWS[name] for name in sorted(PLASTIC)])
    return [*((name, "f8") for name in numbers), _OWN_FIELDS[0], ("dopamine", "i8")]


def _parameters(laws: Iterable[SynapseLaw]) -> dict[str, None]:
    return dict.fromkeys(name for law in laws for name in law.parameters)


def _state(laws: Iterable[SynapseLaw]) -> dict[str, None]:
    return dict.fromkeys(name for law in laws for name in law.state)
