"""Brains of one network share its initial engine, and none changes another one."""

import numpy as np
from nrp_brain_event import EventBackend, EventOptions

from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network


def voltages(brain):
    brain.run_until(brain.now_ns + 40 * NS_PER_MS)
    return brain.read_state("v", [0, 1, 2]).tobytes()


def test_changes_of_one_brain_are_not_those_of_another(cells, connect):
    pairs = [(0, 1), (1, 2), (2, 0)]
    parts = cells("a", "IF_cond_exp", 3, i_offset=0.7), connect("a", "a", 0.02, pairs=pairs, label="p")
    network = Network({"a": parts[0]}, (parts[1],))

    def opened():
        return EventBackend().open(network, seed=1, options=EventOptions())

    with opened() as alone:
        expected = voltages(alone)
    one, other = opened(), opened()
    with one, other:
        assert one._initial.cells is other._initial.cells
        voltages(one)
        one.set_parameters(np.array([0, 1]), {"cm": 0.5})
        one.set_weights("p", 0.3)
        assert voltages(one) != expected
        assert voltages(other) == expected
        one.reset()
        assert voltages(one) == expected
    with opened() as later:
        assert voltages(later) == expected
