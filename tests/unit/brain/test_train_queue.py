"""Spikes leave the queue in the window they belong to, each once, by emitter and in order."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.devices.source_cells import TrainQueue
from nrp_core.clock import NS_PER_MS
from nrp_core.network.grid import Grid

SPIKES = st.lists(st.tuples(st.integers(0, 4), st.integers(1, 40), st.floats(-1, 1)), max_size=20)


@given(st.lists(SPIKES, max_size=5), st.lists(st.integers(0, 15), min_size=1, max_size=6))
def test_each_spike_leaves_once_in_the_first_window_that_reaches_it(batches, windows):
    queue, waiting, until = TrainQueue(Grid(NS_PER_MS // 10)), [], 0
    for turn, length in enumerate(windows):
        batch = batches[turn] if turn < len(batches) else []
        waiting += batch
        queue.put(*(np.array([row[i] for row in batch], kind) for i, kind in enumerate((int, int, float))))
        until += length
        due = [row for row in waiting if row[1] <= until]
        waiting = [row for row in waiting if row[1] > until]
        emitters, trains = queue.take(until)
        assert emitters.tolist() == sorted({emitter for emitter, _, _ in due})
        for emitter, (times_ms, weights) in zip(emitters.tolist(), trains, strict=True):
            own = [row for row in due if row[0] == emitter]
            assert times_ms == sorted(times_ms)
            found = zip(np.round(np.array(times_ms) / 0.1).tolist(), weights, strict=True)
            assert sorted(found) == sorted(row[1:] for row in own)


def test_an_empty_queue_gives_nothing():
    emitters, trains = TrainQueue(Grid(NS_PER_MS)).take(10)
    assert emitters.size == 0
    assert trains == []
