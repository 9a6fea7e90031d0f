"""The assumed activity of a network that has not run."""

from __future__ import annotations

from nrp_brain_spinnaker.host.distributions import poisson_share_below
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.data import Population


def spikes_per_tick(population: Population, options: SpinnakerOptions) -> float:
    """Return how often each cell fires in a tick: as a Poisson source says, else as the options do."""
    return rate_hz(population, options) * options.step_us * 1e-6


def rate_hz(population: Population, options: SpinnakerOptions) -> float:
    """Return the rate assumed of each cell: that of a Poisson source, else the option's."""
    rates = population.parameters.get("rate")
    if population.is_source and rates is not None:
        return float(rates.mean())
    return options.spikes_per_second


def share_above(limit: float, mean: float, variance: float) -> float:
    """Return how often a sum of weights, one for each of a Poisson number of spikes, exceeds a limit.

    Exact for equal weights; others are replaced by equal ones that give the same mean and variance.

    Args:
        limit: in the units of the weights, as the mean and the variance.
        mean: of the sum.
        variance: of the sum.
    """
    if mean <= 0 or variance <= 0:
        return 0.0
    weight = variance / mean
    return max(0.0, 1.0 - poisson_share_below(int(limit / weight) + 1, mean / weight))
