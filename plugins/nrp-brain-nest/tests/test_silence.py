"""Cells that fall silent do not slow NEST down: their conductances do not become subnormal."""

import sys

import numpy as np
import pytest
from nrp_core.brain import PoissonSource, builder, network_of
from nrp_core.clock import NS_PER_MS

from nrp_brain_nest import NestBackend

CELLS = 50


def network():
    sim = builder(3)
    sim.setup(timestep=0.1)
    sim.Population(CELLS, sim.IF_cond_alpha(), label="cells")
    return network_of(sim.state, {})


def conductances(options):
    """Return conductances of cells after a burst and a long silence, a row for each step."""
    backend = NestBackend()
    with backend.open(network(), seed=1, options=backend.options(**options)) as brain:
        source = brain.add_source(
            PoissonSource(rate=500.0, weight=0.005, delay=0.5), range(CELLS), name="device"
        )
        brain.run_until(100 * NS_PER_MS)
        source.rate = 0.0
        values = []
        for t_ms in range(3000, 4200, 20):  # exp(-3.6 s / 5 ms) is 1e-313
            brain.run_until(t_ms * NS_PER_MS)
            values.append(brain._nest.NodeCollection(brain._cells.nodes.tolist()).get("g_ex"))
    return np.abs(np.array(values))


@pytest.mark.parametrize("threads", [1, 2])
def test_no_conductance_of_a_silent_cell_is_subnormal(threads):
    found = conductances({"threads": threads})
    assert (found[0] > 0).all()
    assert not ((found > 0) & (found < sys.float_info.min)).any()
    assert (found[-1] < 1e-300).all()  # so far down it came


def test_subnormal_numbers_are_as_ever_outside_of_a_step():
    conductances({})
    assert np.full(4, sys.float_info.min)[0] * 0.5 > 0
