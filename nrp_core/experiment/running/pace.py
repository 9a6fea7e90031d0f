"""Populations that fired as often as no neuron does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from nrp_core.brain.network.data import Network
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level

_FASTEST_HZ: Final = 2000.0
"""A mean rate of the cells of a population; the fastest neurons fire at 1 kHz (electric fish: M. A. Moortgat
et al., J. Neurophysiol. 79:1158, 1998)."""
_SHORTEST_S: Final = 0.02


def too_fast(
    experiment: Experiment, network: Network, spikes: Mapping[str, int], now_s: float
) -> Iterator[Finding]:
    """Yield a finding for each population that fires too often; sources may stand for many neurons.

    Args:
        experiment: the experiment that runs.
        network: its network.
        spikes: the number of spikes of each population so far.
        now_s: the simulated time reached, s.
    """
    if now_s < _SHORTEST_S:
        return
    for label, population in network.populations.items():
        rate_hz = spikes.get(label, 0) / population.size / now_s
        if rate_hz > _FASTEST_HZ and not population.is_source:
            message = (
                f"each cell of the population '{label}' fired {rate_hz:.3g} times a second; is a weight or a "
                "current in another unit?"
            )
            place = experiment.place("brain", "model")
            yield place.finding(Code.NRP325, message, Level.WARNING)
