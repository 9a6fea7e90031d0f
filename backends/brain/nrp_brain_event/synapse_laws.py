"""The synapse laws that the engine runs. Importing this does not load a compiler.

A law whose spikes transmit a fraction of the weight is one entry in :data:`SHARES`: its kernel gets the
record of a synapse and the time of a spike (ms), returns the fraction, and updates the record. The record
holds the law's parameters and state, ``tau_psc`` (time constant of the target's synapse, ms, 0 for a delta
synapse) and ``t`` (the last spike, ms; 0 at first). A
kernel that draws calls :func:`nrp_brain_event.random_numbers.uniform` with the record.

A law whose spikes change the weight is one entry in :data:`RULES`, by its own name or by that of its part
that sets it apart: a module with two kernels; see :mod:`nrp_brain_event.rules`.

A law that is given as equations is an entry in both, since its kernel is written for it: see
:mod:`nrp_brain_event.equations.synapse_kernels`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, Protocol

from nrp_core.brain.network.equations.synapse_model import SYNAPSE_TYPE
from nrp_core.brain.network.synapses.law import SynapseLaw
from nrp_core.brain.network.synapses.laws import LAWS, PLASTIC
from nrp_core.brain.network.synapses.multiquantal import MULTIQUANTAL
from nrp_core.brain.network.synapses.simple_stochastic import SIMPLE_STOCHASTIC
from nrp_core.brain.network.synapses.static import STATIC
from nrp_core.brain.network.synapses.stochastic_tsodyks_markram import STOCHASTIC_TSODYKS_MARKRAM
from nrp_core.brain.network.synapses.tsodyks_markram import TSODYKS_MARKRAM

Share = Callable[[Any, float], float]


class PlasticityRule(Protocol):
    """The module of a rule."""

    def on_source(self, rule: Any, synapse: Any, t: float) -> None:
        """Update a synapse for a spike of its source that it processes at t (ms)."""

    def on_target(self, rule: Any, synapse: Any, t: float) -> None:
        """Update a synapse for a spike of its target that it processes at t (ms)."""


def _tsodyks_markram() -> Share:
    from nrp_core.brain.network.synapses.tsodyks_markram_kernel import released_share

    return released_share


def _simple_stochastic() -> Share:
    from nrp_brain_event.shares.simple_stochastic import share

    return share


def _stochastic_tsodyks_markram() -> Share:
    from nrp_brain_event.shares.stochastic_tsodyks_markram import share

    return share


def _multiquantal() -> Share:
    from nrp_brain_event.shares.multiquantal import share

    return share


def _spike_pairs() -> PlasticityRule:
    from nrp_brain_event.rules import spike_pairs

    return spike_pairs


def _vogels() -> PlasticityRule:
    from nrp_brain_event.rules import vogels

    return vogels


def _spike_triplets() -> PlasticityRule:
    from nrp_brain_event.rules import spike_triplets

    return spike_triplets


def _equation_share() -> Share:
    from nrp_brain_event.equations.synapse_kernels import strength

    return strength


def _equation_rule() -> PlasticityRule:
    from nrp_brain_event.equations import synapse_kernels

    return synapse_kernels


SHARES: Final[Mapping[str, Callable[[], Share]]] = {
    TSODYKS_MARKRAM: _tsodyks_markram,
    SIMPLE_STOCHASTIC: _simple_stochastic,
    STOCHASTIC_TSODYKS_MARKRAM: _stochastic_tsodyks_markram,
    MULTIQUANTAL: _multiquantal,
    SYNAPSE_TYPE: _equation_share,
}
"""The loader of each law's kernel."""

RULES: Final[Mapping[str, Callable[[], PlasticityRule]]] = {
    "SpikePairRule": _spike_pairs,
    "Vogels2011Rule": _vogels,
    "PfisterSpikeTripletRule": _spike_triplets,
    SYNAPSE_TYPE: _equation_rule,
}
"""The loader of each rule's module."""

SYNAPSES: Final = frozenset(
    {
        STATIC,
        *SHARES,
        *(
            name
            for name in PLASTIC
            if RULES.keys() & {name, *(one for of in LAWS[name].parts.values() for one in of)}
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


def plastic_fields() -> list[tuple[str, str]]:
    """Return the fields of a plastic synapse for the state of all laws."""
    return [(name, "f8") for name in _state([LAWS[name] for name in sorted(PLASTIC)])]


def rule_fields() -> list[tuple[str, str]]:
    """Return the fields of the parameters of all plastic laws."""
    return [*((name, "f8") for name in _parameters([LAWS[name] for name in sorted(PLASTIC)])), _OWN_FIELDS[0]]


def _parameters(laws: Iterable[SynapseLaw]) -> dict[str, None]:
    return dict.fromkeys(name for law in laws for name in law.parameters)


def _state(laws: Iterable[SynapseLaw]) -> dict[str, None]:
    return dict.fromkeys(name for law in laws for name in law.state)
