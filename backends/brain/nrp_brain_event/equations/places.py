"""Where the records of synapses have room for the parameters and variables of laws given as equations.

The records are those of all laws, so that the engine is compiled once. A law given as equations uses the
fields of the others, which are free in its synapses. All fields have the same size, so a field is a place in
an array.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from nrp_brain_event.records import Plastic, Rule, ShortTerm
from nrp_core.brain.network.equations.synapse import SYNAPSE_TYPE, SynapseModel
from nrp_core.errors import CapabilityError

_SHORT_TERM: Final = ShortTerm.dtype().names or ()
_PLASTIC: Final = Plastic.dtype().names or ()
_RULE: Final = Rule.dtype().names or ()
_LAST: Final = "pre_t"
"""The time of the last spike of either side at a plastic synapse."""


class Places(NamedTuple):
    """The fields of a law.

    Args:
        parameters: of the record of the synapse, or of the rule of a plastic one.
        state: of the record of the synapse.
        last: the time of the last update, ms.
        share: of the record of the synapse.
        weight: the magnitude of a plastic weight.
        scale: what it is multiplied by in the equations.
    """

    parameters: dict[str, int]
    state: dict[str, int]
    last: int
    share: int = -1
    weight: int = -1
    scale: int = -1


def places_of(model: SynapseModel, owner: str) -> Places:
    """Return the fields of a law.

    Args:
        model: the law.
        owner: the projection, for the message.

    Raises:
        CapabilityError: the records have too few.
    """
    if not model.is_plastic:
        free = _free(_SHORT_TERM, ("law", "tau_psc", "t", "stream", "own", "share"))
        _require(
            len(model.parameters) + len(model.variables), len(free), "parameters and state variables", owner
        )
        state = dict(zip(model.variables, free, strict=False))
        parameters = dict(zip(model.parameters, free[len(state) :], strict=False))
        return Places(parameters, state, _SHORT_TERM.index("t"), share=_SHORT_TERM.index("share"))
    free = _free(_PLASTIC, ("rule", "target", "weight", "dendritic_delay", "last_seen", _LAST))
    scale, *of_rule = _free(_RULE, ("law", "sign", "own"))
    _require(len(model.variables), len(free), "state variables", owner)
    _require(len(model.parameters), len(of_rule), "parameters", owner)
    return Places(
        dict(zip(model.parameters, of_rule, strict=False)), dict(zip(model.variables, free, strict=False)),
        _PLASTIC.index(_LAST), weight=_PLASTIC.index("weight"), scale=scale,
    )  # fmt: skip


def _free(names: Sequence[str], used: Iterable[str]) -> list[int]:
    return [place for place, name in enumerate(names) if name not in used]


def _require(needed: int, room: int, what: str, owner: str) -> None:
    if needed > room:
        raise CapabilityError(
            f"{owner}: its equations have {needed} {what}; on 'event' an {SYNAPSE_TYPE} of this kind has at "
            f"most {room}"
        )
