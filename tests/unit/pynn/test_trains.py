"""Trains of a list that is divided in one pass."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
import quantities as pq
from matplotlib.figure import Figure
from neo.core import spiketrain
from neo.core.spiketrainlist import SpikeTrainList

from nrp_core.pynn.spike_trains import SpikeTrains


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
    own = {name: value for name, value in vars(train).items() if name not in ("_dimensionality", "segment")}
    return train.magnitude.tolist(), train.units, type(train).__name__, own, train.array_annotations.length


def test_trains_are_those_that_neo_makes() -> None:
    plain, ours = lists()
    assert len(ours) == 6
    assert [described(train) for train in ours] == [described(train) for train in plain]
    assert len(ours[5]) == 0
    assert ours[1].segment is plain[1].segment is None
    assert [array.tolist() for array in ours.multiplexed] == [array.tolist() for array in plain.multiplexed]


def test_a_file_of_them_needs_only_neo() -> None:
    _, ours = lists()
    stored = pickle.dumps(ours)
    assert b"nrp_core" not in stored
    again = pickle.loads(stored)
    assert type(again) is SpikeTrainList
    assert [described(train) for train in again] == [described(train) for train in ours]


def test_a_change_of_one_train_leaves_the_others() -> None:
    _, ours = lists()
    times, stops = ours.multiplexed[1].magnitude.tolist(), [float(train.t_stop) for train in ours]
    ours[0][:] = 1.0 * pq.ms
    ours[0].t_stop += 5.0 * pq.ms
    ours[0].annotate(own=1)
    assert ours.multiplexed[1].magnitude.tolist() == times
    assert [float(train.t_stop) for train in ours][1:] == stops[1:]
    assert "own" not in ours[1].annotations


def test_numpy_and_matplotlib_sort_trains() -> None:
    """``eventplot`` calls ``numpy.sort``, which passes an axis that Neo's own trains refuse."""
    _, ours = lists()
    assert np.sort(ours[0]).magnitude.tolist() == sorted(ours[0].magnitude.tolist())
    rows = Figure().subplots().eventplot(list(ours))
    assert [len(row.get_positions()) for row in rows] == [len(train) for train in ours]


def test_the_times_of_all_trains_are_checked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    checked: list[int] = []
    check = spiketrain._check_time_in_range
    monkeypatch.setattr(
        spiketrain,
        "_check_time_in_range",
        lambda times, *a, **k: (checked.append(len(times)), check(times, *a, **k)),
    )
    plain, ours = lists()
    assert len(list(plain)) == len(checked) == 6
    checked.clear()
    assert len(list(ours)) == 6
    assert checked == [50]
