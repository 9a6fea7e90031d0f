"""Trains of a list that is divided in one pass."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import quantities as pq
from neo.core.spiketrainlist import SpikeTrainList

from nrp_core.pynn.recorder import SpikeTrains


def lists(n: int = 6) -> tuple[SpikeTrainList, SpikeTrainList]:
    rng = np.random.default_rng(4)
    owners = rng.integers(10, 10 + n - 1, 50)  # the last cell has no spikes
    times = rng.uniform(0.0, 100.0, 50)

    def new() -> SpikeTrainList:
        return SpikeTrainList.from_spike_time_array(
            times, owners, np.arange(10, 10 + n), t_stop=100.0 * pq.ms, units="ms",
            source_population="cells", source_index=np.arange(n),
        )  # fmt: skip

    return new(), SpikeTrains(new())


def described(train: Any) -> Any:
    return train.magnitude.tolist(), float(train.t_start), float(train.t_stop), train.units, train.annotations


def test_trains_are_those_that_neo_makes() -> None:
    plain, ours = lists()
    assert len(ours) == 6
    assert [described(train) for train in ours] == [described(train) for train in plain]
    assert len(ours[5]) == 0
    assert [array.tolist() for array in ours.multiplexed] == [array.tolist() for array in plain.multiplexed]


def test_a_file_of_them_needs_only_neo() -> None:
    _, ours = lists()
    stored = pickle.dumps(ours)
    assert b"nrp_core" not in stored
    again = pickle.loads(stored)
    assert type(again) is SpikeTrainList
    assert [described(train) for train in again] == [described(train) for train in ours]
