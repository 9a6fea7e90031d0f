"""The binary point of ring-buffer entries, chosen before the run from the expected weights.

One left shift for each population and receptor must leave room for the input in one tick and keep the
resolution of small weights. The rules are those of sPyNNaker 7.4.1, whose sum of all weights omits the scale
of conductances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from nrp_brain_spinnaker.host.distributions import poisson_share_below


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
