"""Synapse types that scripts give as equations."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from pyNN.standardmodels import StandardSynapseType

from nrp_core.brain.network.equations.synapse import SynapseEquations
from nrp_core.brain.network.equations.synapse_model import SYNAPSE_TYPE
from nrp_core.brain.pynn.models import untranslated
from nrp_core.brain.pynn.quantities import require_dictionaries, require_texts, value_with_unit
from nrp_core.brain.pynn.synapses import SynapseType

_NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})
_EXAMPLES: Final = {
    "equations": "dx/dt = (1 - x)/tau : 1 (event-driven)", "on_pre": "share = x; x *= 0.5",
    "on_post": "weight += a_plus*x", "weight_unit": "nA",
}  # fmt: skip


def equation_synapse(
    equations: str,
    on_pre: str = "",
    on_post: str = "",
    *,
    parameters: Mapping[str, Any] = _NOTHING,
    initial: Mapping[str, Any] = _NOTHING,
    weight_unit: str = "1",
    name: str = SYNAPSE_TYPE,
    **unknown: Any,
) -> type:
    """Return a synapse type of equations, in the notation of Brian2.

    It is used as any of PyNN's: ``sim.Projection(a, b, connector, Law(weight=0.1, delay=1.0))``, with other
    values as in ``Law(tau=...)``, which are numbers in the unit of the default.

    Args:
        equations: one a line: ``dx/dt = ... : 1 (event-driven)`` for a state variable of each synapse,
            ``y = ... : 1`` for an expression with a name, ``tau : ms`` for a parameter.
        on_pre: what a spike of the source does: assignments to state variables, one a line or divided by
            ``;``. The spike arrives with ``share = ...`` of the weight, or changes it: ``weight += ...``.
        on_post: what a spike of the target does, in laws that change the weight.
        parameters: default value and unit of each parameter, e.g. ``{"tau": "20 ms"}``.
        initial: values of state variables at time 0, e.g. ``{"x": 1}``; by default 0.
        weight_unit: the unit of ``weight``, e.g. ``nA``; ``1`` for its number in the units of scripts.
        name: the name of the synapse type in messages.
        unknown: not allowed.

    Raises:
        NetworkError: the texts do not fit together; the message names the line.
    """
    texts = {"equations": equations, "on_pre": on_pre, "on_post": on_post, "weight_unit": weight_unit}
    require_texts(SYNAPSE_TYPE, texts, _EXAMPLES, unknown)
    require_dictionaries(SYNAPSE_TYPE, {"parameters": parameters, "initial": initial})
    defaults = {
        key: value_with_unit("parameters", key, value, SYNAPSE_TYPE) for key, value in parameters.items()
    }
    units = {key: unit.text for key, (_, unit) in defaults.items()}
    law = SynapseEquations(**texts, units=units, initial={key: str(value) for key, value in initial.items()})
    own = {"weight": 0.0, "delay": None, **{key: value for key, (value, _) in defaults.items()}}
    body = {
        "__doc__": "A synapse given as equations:\n\n" + equations.strip("\n"),
        "kind": SYNAPSE_TYPE,
        "equations": law,
        "default_parameters": own,
        "translations": untranslated(own),
    }
    return type(name, (SynapseType, StandardSynapseType), body)
