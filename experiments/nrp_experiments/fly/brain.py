"""A brain of the size of a fly's: the synthetic twin, or a smaller one."""

from twin import twin

import nrp_core.pynn as sim

cells = sim.parameter(
    "cells", 138_639, low=2500, high=1_000_000, doc="number of cells; FlyWire v783 has 138 639"
)
wiring = sim.parameter("wiring", 783, low=0, doc="seed of the synthetic wiring")

network = twin(cells, wiring)
