"""From weights in a network to raw 16-bit weights on the machine."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nrp_brain_spinnaker import kinds
from nrp_brain_spinnaker.conversion import from_accum, to_accum
from nrp_brain_spinnaker.distributions import Distribution, binomial_quantile, parse_distribution
from nrp_brain_spinnaker.kinds import Cells
from nrp_brain_spinnaker.models import CellModel
from nrp_brain_spinnaker.ring import WeightArray
from nrp_brain_spinnaker.shifts import Incoming
from nrp_core.brain.network import STDP, TSODYKS_MARKRAM, FloatArray, Projection

GENERATED_ON_MACHINE = frozenset(
    f"{name}Connector"
    for name in (
        "AllToAll", "OneToOne", "FixedProbability", "FixedNumberPre", "FixedNumberPost", "FixedTotalNumber",
    )
)  # fmt: skip
"""The connectors that the released software expands on the cores and not on the host."""


def weight_scale(shift: int, scale: int) -> float:
    """Return raw units per unit of weight: nA, or uS with a ``scale`` of 1024."""
    return 2.0 ** (15 - shift) * scale


def host_raw(sizes: FloatArray, shift: int, scale: int) -> WeightArray:
    """Convert weights (without sign) as the host does: to the nearest, ties to even, low 16 bits."""
    return _masked(np.rint(sizes * weight_scale(shift, scale)))


def machine_raw(sizes: FloatArray, shift: int, scale: int) -> WeightArray:
    """Convert weights as a core does that expands a connector: to s16.15 first, then ties up."""
    return _masked(np.floor(from_accum(to_accum(sizes, "weight")) * weight_scale(shift, scale) + 0.5))


def _masked(raw: FloatArray) -> WeightArray:
    return (raw.astype(np.int64) & 0xFFFF).astype(np.uint16)


def is_machine_generated(projection: Projection, model: CellModel) -> bool:
    """Whether the released software would draw these synapses on the machine.

    It cannot for what it does not have (extensions) nor for weights that are given one by one.
    """
    known = projection.synapse_type != TSODYKS_MARKRAM and not model.extension
    return (
        known and projection.origin.connector in GENERATED_ON_MACHINE and projection.origin.weight is not None
    )


def weight_factors(cells: Cells, neurons: slice, model: CellModel) -> FloatArray | None:
    """Return what weights onto neurons are multiplied by to be in the units of their synapses; None for 1.

    A weight in mV becomes the current that lifts the membrane by as much in one step.
    """
    if not model.weights_in_mv:
        return None
    constants = from_accum(cells.constants[:, neurons])
    lift = constants[kinds.IMPULSE_GAIN] * constants[kinds.R_MEMBRANE] * (1 - constants[kinds.EXP_TC])
    return np.asarray(1 / lift)


def incoming_of(
    projection: Projection, sizes: FloatArray, n_pre: int, n_post: int, *, as_given: bool
) -> Incoming:
    """Describe a projection for the choice of the shift.

    Args:
        projection: the projection, with at least one synapse.
        sizes: its weights without sign, in the units of the target.
        n_pre: cells of the population it comes from.
        n_post: cells of the population it ends on.
        as_given: whether the sizes are those of the projection's origin, so that its distribution holds.
    """
    given = parse_distribution(projection.origin.weight) if as_given else None
    delays = parse_distribution(projection.origin.delay)
    drawn = given or _observed(sizes)
    largest = given.most_probable_extreme(projection.size) if given else float(sizes.max())
    if projection.synapse_type == STDP:
        largest = max(largest, float(np.abs(projection.synapse_parameters["w_max"]).max()))
    return Incoming(
        connections=_connections(projection, n_pre, n_post),
        largest=largest,
        mean=abs(drawn.mean),
        variance=drawn.variance,
        delay_variance=delays.variance if delays else _variance(projection.delay_ms),
    )


def _observed(values: FloatArray) -> Distribution:
    return Distribution(float(values.mean()), _variance(values), lambda p: float(np.quantile(values, p)))


def _variance(values: FloatArray) -> float:
    """Return the variance, exactly 0 for equal values."""
    return float(values.var()) if np.ptp(values) > 0 else 0.0


def _connections(projection: Projection, n_pre: int, n_post: int) -> int:
    """Return the largest probable number of synapses of a projection onto one neuron."""
    if projection.origin.connector == "FixedProbabilityConnector":
        probability = _probability(projection.origin.parameters)
        if probability is not None:
            return binomial_quantile(n_pre, probability, 1 - 1e-4 / (n_pre * n_post))
    return int(np.bincount(projection.post_index).max())


def _probability(parameters: Mapping[str, object]) -> float | None:
    value = parameters.get("p_connect")
    return float(value) if isinstance(value, (int, float)) else None
