"""The assumed activity of a network before a run."""

from __future__ import annotations

from nrp_brain_spinnaker.host.distributions import poisson_share_below
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.data import Population


def spikes_per_tick(population: Population, options: SpinnakerOptions) -> float:
    """Return the assumed spikes of each cell per tick: a Poisson source's own, else the options'."""
    return rate_hz(population, options) * options.step_us * 1e-6


def rate_hz(population: Population, options: SpinnakerOptions) -> float:
    """Return the assumed rate of each cell: that of a Poisson source, else the option's."""
    rates = population.parameters.get("rate")
    if population.is_source and rates is not None:
        return float(rates.mean())
    return options.spikes_per_second


def share_above(limit: float, mean: float, variance: float) -> float:
    """Return the probability that the weights of a Poisson number of spikes add up to more than a limit.

    Exact for equal weights; others are replaced by equal ones that give the same mean and variance.

    Args:
        limit: the limit, in the units of the weights, as are the moments.
        mean: mean of the sum.
        variance: variance of the sum.
    """
    if mean <= 0 or variance <= 0:
        return 0.0
    weight = variance / mean
    return max(0.0, 1.0 - poisson_share_below(int(limit / weight) + 1, mean / weight))
