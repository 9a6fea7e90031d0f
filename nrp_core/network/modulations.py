"""The parameters that the rewards of each population share, for backends with rewards."""

from __future__ import annotations

from typing import Final

from nrp_core.errors import CapabilityError
from nrp_core.network.data import Network, Projection
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import STDP

_PAIRS: Final = "SpikePairRule"
_ADDITIVE: Final = "AdditiveWeightDependence"


def follows_dopamine(projection: Projection) -> bool:
    """Return whether the weights of synapses follow dopamine, if a projection releases it."""
    equations = projection.equations
    return projection.synapse_type == STDP or (equations is not None and bool(equations.model.eligibility))


def modulations_of(network: Network) -> dict[str, Neuromodulation]:
    """Return the parameters that the rewards of each population share, by its label.

    Raises:
        CapabilityError: their parameters differ, or no synapse learns from them.
    """
    found: dict[str, Neuromodulation] = {}
    for one in network.projections:
        if one.neuromodulation is None:
            continue
        if found.setdefault(one.post, one.neuromodulation) != one.neuromodulation:
            raise CapabilityError(
                f"projection '{one.label}': all rewards and punishments of '{one.post}' have the same tau_c, "
                "tau_d, w_min, w_max, baseline, shared and eligibility_limits"
            )
        if not any(other.post == one.post and follows_dopamine(other) for other in network.projections):
            raise CapabilityError(
                f"projection '{one.label}': rewards and punishments decide on changes by STDP; no synapses "
                f"onto '{one.post}' have it"
            )
    for one in network.projections:
        if one.post in found and one.synapse_type == STDP:
            _require_pairs(one, found[one.post])
    return found


def _require_pairs(projection: Projection, modulation: Neuromodulation) -> None:
    rule, dependence = (
        projection.plasticity.get(part) for part in ("timing_dependence", "weight_dependence")
    )
    if rule != _PAIRS:
        raise CapabilityError(
            f"projection '{projection.label}': rewards decide on changes by {_PAIRS}, not by {rule}"
        )
    if not modulation.eligibility_limits and dependence != _ADDITIVE:
        raise CapabilityError(
            f"projection '{projection.label}': an eligibility without limits needs {_ADDITIVE}; {dependence} "
            "refers to them"
        )
