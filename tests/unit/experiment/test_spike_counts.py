"""The number of spikes in the result of a run."""

from __future__ import annotations

import numpy as np

from nrp_core.brain.spikes import Spikes
from nrp_core.experiment.running.observation import SpikeCounter
from nrp_core.network.data import Network, Population


def test_a_population_with_a_name_is_not_reported_again_by_its_automatic_one() -> None:
    labels = ("population0", "rest", "population2")
    populations = {label: Population(label, 2, "IF_curr_exp", {}) for label in labels}
    views = {"wheels": np.array([0, 1]), "left": np.array([0]), "others": np.array([2, 3])}
    network = Network(populations, (), views)
    counter = SpikeCounter().open(np.arange(6), 6, "result")
    counter.receive(Spikes(np.array([0, 0, 1, 3]), np.arange(4.0)), 10.0)
    assert counter.of(network) == {
        "wheels": 3, "left": 2, "others": 1, "rest": 1, "population2": 0,
    }  # fmt: skip
