"""Synapses are found again whatever order they are kept in."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.network.grid import same_order

SYNAPSE = st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(1, 2), st.floats(0, 1))


@given(st.lists(SYNAPSE, min_size=1, max_size=30), st.randoms(use_true_random=False))
def test_synapses_are_found_again_after_a_shuffle_and_a_change_that_keeps_their_rank(rows, random):
    names = ("source", "target", "delay", "weight")
    shuffled = random.sample(range(len(rows)), len(rows))
    ours = {name: np.array([row[i] for row in rows]) for i, name in enumerate(names)}
    theirs = {name: values[shuffled] for name, values in ours.items()}
    theirs["weight"] = 0.5 * theirs["weight"] + 0.25
    first, second = same_order(ours, theirs)
    for name in names[:3]:
        assert ours[name][first].tolist() == theirs[name][second].tolist()
    np.testing.assert_array_equal(0.5 * ours["weight"][first] + 0.25, theirs["weight"][second])
