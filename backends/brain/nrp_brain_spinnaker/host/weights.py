"""Convert weights of a network to raw 16-bit weights on the machine.

The host's estimates of random weights, delays and connection counts before they are drawn.

The binary point of ring-buffer entries, chosen before the run from the expected weights.

One left shift for each population and receptor must leave room for the input in one tick and keep the
resolution of small weights. The rules are those of sPyNNaker 7.4.1, whose sum of all weights omits the scale
of conductances.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import NormalDist

import numpy as np

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import from_accum, to_accum
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.synaptic_inputs import WeightArray
from nrp_brain_spinnaker.models import EXTENDED_SYNAPSES, CellModel
from nrp_core._support.arrays import FloatArray
from nrp_core.network.data import Projection
from nrp_core.network.limits import distinct
from nrp_core.network.synapses import STDP

_TEXT = re.compile(r"\s*(\w+)\((.*)\)\s*\Z")


@dataclass(frozen=True, slots=True)
class Distribution:
    """A random distribution.

    Args:
        mean, variance: its moments.
        quantile: the value below which a share of the draws is.
    """

    mean: float
    variance: float
    quantile: Callable[[float], float]

    def most_probable_extreme(self, n: int) -> float:
        """Return the absolute value that the largest of ``n`` draws exceeds with probability 1 %."""
        chance = 0.01 / max(n, 1)
        return abs(self.quantile(chance if self.mean < 0 else 1 - chance))


def parse_distribution(text: object) -> Distribution | None:
    """Read the text of a distribution such as ``normal(mu=0.5, sigma=0.1)``; None for others."""
    match = _TEXT.match(text) if isinstance(text, str) else None
    if match is None or match[1] not in _KNOWN:
        return None
    try:
        pairs = (part.split("=") for part in match[2].split(","))
        parameters = {name.strip(): float(value) for name, value in pairs}
        return _KNOWN[match[1]](parameters)
    except (ValueError, KeyError):
        return None


def _uniform(given: Mapping[str, float]) -> Distribution:
    low, high = given["low"], given["high"]
    return Distribution((low + high) / 2, (high - low) ** 2 / 12, lambda p: low + p * (high - low))


def _normal(given: Mapping[str, float]) -> Distribution:
    normal = NormalDist(given["mu"], given["sigma"])
    return Distribution(normal.mean, normal.variance, normal.inv_cdf)


def _clipped(given: Mapping[str, float], *, redrawn: bool) -> Distribution:
    """Return a truncated normal distribution with moments from a fine grid of quantiles."""
    normal, low, high = NormalDist(given["mu"], given["sigma"]), given["low"], given["high"]
    first, last = (normal.cdf(low), normal.cdf(high)) if redrawn else (0.0, 1.0)

    def quantile(p: float) -> float:
        inside = min(max(first + p * (last - first), 1e-12), 1 - 1e-12)
        return min(max(normal.inv_cdf(inside), low), high)

    values = np.array([quantile((k + 0.5) / 1000) for k in range(1000)])
    return Distribution(float(values.mean()), float(values.var()), quantile)


def _exponential(given: Mapping[str, float]) -> Distribution:
    beta = given["beta"]
    return Distribution(beta, beta**2, lambda p: -beta * math.log1p(-p))


def _lognormal(given: Mapping[str, float]) -> Distribution:
    mu, sigma = given["mu"], given["sigma"]
    mean = math.exp(mu + sigma**2 / 2)
    variance = math.expm1(sigma**2) * mean**2
    return Distribution(mean, variance, lambda p: math.exp(NormalDist(mu, sigma).inv_cdf(p)))


_KNOWN: Mapping[str, Callable[[Mapping[str, float]], Distribution]] = {
    "uniform": _uniform,
    "normal": _normal,
    "normal_clipped": partial(_clipped, redrawn=True),
    "normal_clipped_to_boundary": partial(_clipped, redrawn=False),
    "exponential": _exponential,
    "lognormal": _lognormal,
}


def binomial_quantile(n: int, probability: float, share: float) -> int:
    """Return the quantile ``share`` of a binomial distribution."""
    if n == 0 or probability <= 0:
        return 0
    if probability >= 1 or share >= 1:
        return n
    k = np.arange(n + 1)
    factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, n + 1)))])
    logs = factorials[n] - factorials[k] - factorials[n - k]
    logs += k * math.log(probability) + (n - k) * math.log1p(-probability)
    above: FloatArray = np.cumsum(np.exp(logs)[::-1])[::-1] - np.exp(logs)
    return int(np.argmax(above <= 1 - share))


def poisson_share_below(limit: int, mean: float) -> float:
    """Return the probability that a Poisson variate is below ``limit``."""
    return math.fsum(math.exp(k * math.log(mean) - mean - math.lgamma(k + 1)) for k in range(limit))


@dataclass(frozen=True, slots=True)
class Incoming:
    """The possible input from one projection to a receptor of one neuron.

    Args:
        connections: the largest probable number of synapses onto one neuron.
        largest: the largest probable absolute weight.
        mean, variance: moments of the absolute weights.
        delay_variance: variance of the delays in the projection.
    """

    connections: int
    largest: float
    mean: float
    variance: float
    delay_variance: float


@dataclass(frozen=True, slots=True)
class Expectation:
    """The host's assumptions about activity.

    Args:
        spikes_per_second: rate of every source neuron.
        sigma: number of standard deviations of the summed input that must fit.
        step_ms: length of a tick, ms.
    """

    step_ms: float
    spikes_per_second: float = 30.0
    sigma: float = 5.0


def left_shift(largest: float) -> int:
    """Return the shift with which a weight of this size, and one bit more, fits 16 bits."""
    if largest <= 0:
        return 0
    shift = math.ceil(max(0.0, math.log2(largest)))
    return shift + 1 if 2**shift <= largest else shift


def largest_input(
    incoming: Sequence[Incoming], weight_scale: int, expected: Expectation, *, total_scale: int = 1
) -> float:
    """Return the largest input to one receptor in one tick, in the units of the synapse.

    With equal delays in each projection all input is assumed to arrive at once; else the bound is
    statistical.

    Args:
        incoming: the possible input from each projection.
        weight_scale: scale of the synapse, 1024 for conductances.
        expected: the assumed activity.
        total_scale: the same for the sum of all weights; sPyNNaker omits it.
    """
    spikes_a_tick = max(1.0, expected.spikes_per_second * expected.step_ms / 1000)
    total = total_scale * sum(spikes_a_tick * part.largest * part.connections for part in incoming)
    biggest = max((part.largest * weight_scale for part in incoming), default=0.0)
    if all(part.delay_variance == 0 for part in incoming):
        return max(total, biggest)
    return max(min(_statistical_bound(incoming, weight_scale, expected), total), biggest)


def _statistical_bound(incoming: Sequence[Incoming], weight_scale: int, expected: Expectation) -> float:
    n = sum(part.connections for part in incoming)
    mean = sum(part.connections * part.mean for part in incoming) / n
    square = sum(part.connections * (part.variance + part.mean**2) for part in incoming) / n
    variance = max(square - mean**2, 0.0) * weight_scale**2
    mean *= weight_scale
    rate = n * expected.spikes_per_second * expected.step_ms / 1000
    spread = rate * mean**2 + _weight_variance(rate, variance)
    return rate * mean + expected.sigma * math.sqrt(spread)


def _weight_variance(rate: float, variance: float) -> float:
    """Return the part of the variance of a tick's input that is due to unequal weights."""
    if variance == 0 or rate == 0:
        return 0.0
    most = round(rate + 3 * math.sqrt(rate))
    if not -701 < most * math.log(rate) - math.lgamma(most + 1) < 701:
        return 0.0
    return rate * variance * poisson_share_below(most, rate)


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
