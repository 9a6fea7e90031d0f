"""Synapses of a neuron lie in the order of key, then target."""

from __future__ import annotations

import numpy as np
import pytest
from nrp_brain_event.grid.sorting import sort_by_key


@pytest.mark.parametrize("ascending", [True, False])
@pytest.mark.parametrize("longest", [3, 40, 4000])
def test_the_order_is_that_of_a_sort_by_both(longest: int, ascending: bool) -> None:
    rng = np.random.default_rng(longest)
    first = np.append(0, np.cumsum(rng.integers(0, 200, size=50)))
    keys = rng.integers(1, longest + 1, size=first[-1]).astype(np.uint16)
    targets = rng.integers(0, 3000, size=first[-1]).astype(np.uint16)
    values = rng.random(first[-1]).astype(np.float32)
    neurons = np.repeat(np.arange(50), np.diff(first))
    if ascending:  # as connectors make them
        order = np.lexsort((targets, neurons))
        targets = targets[order]
    expected = np.lexsort((np.arange(len(targets)), targets, keys, neurons))
    sorted_as = [array[expected] for array in (keys, targets, values)]
    sort_by_key(first, keys, targets, values)
    for found, wanted in zip((keys, targets, values), sorted_as, strict=True):
        np.testing.assert_array_equal(found, wanted)
