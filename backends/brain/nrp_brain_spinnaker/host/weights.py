"""Convert weights of a network to raw 16-bit weights on the machine."""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.host.conversion import from_accum, to_accum
from nrp_brain_spinnaker.host.distributions import Distribution, binomial_quantile, parse_distribution
from nrp_brain_spinnaker.host.shifts import Incoming
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.ring import WeightArray
from nrp_brain_spinnaker.models import EXTENDED_SYNAPSES, CellModel
from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Projection
from nrp_core.brain.network.limits import distinct
from nrp_core.brain.network.synapses import STDP

GENERATED_ON_MACHINE = frozenset(
    f"{name}Connector"
    for name in (
        "AllToAll", "OneToOne", "FixedProbability", "FixedNumberPre", "FixedNumberPost", "FixedTotalNumber",
        "OneToOneOffset", "AllButMe",
    )
)  # fmt: skip
"""The connectors that the released software expands on the cores and not on the host."""


def weight_scale(shift: int, scale: int) -> float:
    """Return raw units per unit of weight: nA, or uS with a ``scale`` of 1024."""
    return 2.0 ** (15 - shift) * scale


def host_raw(sizes: FloatArray, shift: int, scale: int) -> WeightArray:
    """Convert absolute weights as the host does: to the nearest, ties to even, low 16 bits."""
    return _masked(np.rint(sizes * weight_scale(shift, scale)))


def machine_raw(sizes: FloatArray, shift: int, scale: int) -> WeightArray:
    """Convert weights as a core that expands a connector does: to s16.15 first, then ties up."""
    return _masked(np.floor(from_accum(to_accum(sizes, "weight")) * weight_scale(shift, scale) + 0.5))


def _masked(raw: FloatArray) -> WeightArray:
    return (raw.astype(np.int64) & 0xFFFF).astype(np.uint16)


def is_machine_generated(projection: Projection, model: CellModel) -> bool:
    """Return whether the released software would draw these synapses on the machine.

    It does not for extensions, nor for weights from an unknown distribution.
    """
    weight = projection.origin.weight
    drawn = isinstance(weight, (int, float)) or parse_distribution(weight) is not None
    if projection.origin.connector == "KernelConnector":
        return True
    known = projection.synapse_type not in EXTENDED_SYNAPSES and not model.extension
    return known and drawn and projection.origin.connector in GENERATED_ON_MACHINE


def weight_factors(cells: Cells, neurons: slice, model: CellModel) -> FloatArray | None:
    """Return the factors that convert weights to the units of the target's synapses; None for 1.

    A weight in mV becomes the current that lifts the membrane by as much in one step.
    """
    if not model.weights_in_mv:
        return None
    constants = from_accum(cells.constants[:, neurons])
    lift = constants[kinds.IMPULSE_GAIN] * constants[kinds.R_MEMBRANE] * (1 - constants[kinds.EXP_TC])
    return np.asarray(1 / lift)


def sizes_of(projection: Projection, factor: FloatArray | None) -> FloatArray:
    """Return the absolute weights of a projection, in the units of the target's synapses.

    Args:
        projection: the projection.
        factor: result of :func:`weight_factors`, for all cells of the target.
    """
    if factor is not None:
        return np.abs(projection.weight) * factor[projection.post_index]
    return np.broadcast_to(np.abs(distinct(projection.weight)), projection.weight.shape)


def incoming_of(projection: Projection, factor: FloatArray | None, n_pre: int, n_post: int) -> Incoming:
    """Describe a projection for the choice of the shift.

    Args:
        projection: the projection; only one whose synapses form and vanish may have none.
        factor: result of :func:`weight_factors`, for all cells of the target.
        n_pre: number of cells of the source population.
        n_post: number of cells of the target population.
    """
    sizes = sizes_of(projection, factor) if projection.size else np.zeros(1)
    given = parse_distribution(projection.origin.weight) if factor is None else None
    delays = parse_distribution(projection.origin.delay)
    drawn = given or _observed(sizes)
    largest = given.most_probable_extreme(projection.size) if given else float(sizes.max())
    limits = common_parameter(projection, "w_max") if projection.synapse_type == STDP else None
    if limits is not None:
        limit = float(np.abs(limits).max())
        largest = max(largest, limit if factor is None else limit * float(factor.max()))
    connections = _connections(projection, n_pre, n_post)
    if projection.rewiring is not None:  # the software expects all weights to be the largest
        largest = max(largest, projection.rewiring.initial_weight)
        return Incoming(connections, largest, mean=largest, variance=0.0, delay_variance=0.0)
    return Incoming(
        connections=connections,
        largest=largest,
        mean=abs(drawn.mean),
        variance=drawn.variance,
        delay_variance=delays.variance if delays else _variance(projection.delay_ms),
    )


def common_parameter(projection: Projection, name: str) -> FloatArray | None:
    """Return a parameter of the law of all synapses of a projection, or of those that will form."""
    values = projection.synapse_parameters.get(name)
    if projection.rewiring is None or (values is not None and values.size):
        return values
    given = projection.rewiring.parameters.get(name)
    return None if given is None else np.array([given])


def _observed(values: FloatArray) -> Distribution:
    return Distribution(float(values.mean()), _variance(values), lambda p: float(np.quantile(values, p)))


def _variance(values: FloatArray) -> float:
    """Return the variance, exactly 0 for equal values."""
    return float(values.var()) if np.ptp(values) > 0 else 0.0


def _connections(projection: Projection, n_pre: int, n_post: int) -> int:
    """Return the largest probable number of synapses of a projection onto one neuron."""
    probability, kernel = connection_probability(projection), projection.origin.parameters.get("kernel_size")
    if isinstance(kernel, int):
        return min(kernel, n_pre)
    if probability is not None:
        return binomial_quantile(n_pre, probability, 1 - 1e-4 / (n_pre * n_post))
    return int(np.bincount(projection.post_index).max(initial=0))


def connection_probability(projection: Projection) -> float | None:
    """Return the probability with which each pair was connected; None for other connectors."""
    value = projection.origin.parameters.get("p_connect")
    if projection.origin.connector != "FixedProbabilityConnector" or not isinstance(value, (int, float)):
        return None
    return float(value)
