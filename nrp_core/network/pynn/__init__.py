"""A PyNN implementation that builds networks as data from scripts written for any PyNN simulator.

Nothing is simulated here. :func:`builder` returns the simulator module of a script; it fills a
:class:`~nrp_core.network.data.Network` with PyNN's own units and meanings.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType, ModuleType

from nrp_core.network.pynn.api import programming_interface
from nrp_core.network.pynn.simulator import Simulator, State
from nrp_core.seeds import Seeds


def builder(seed: int = 0, parameters: Mapping[str, object] = MappingProxyType({})) -> ModuleType:
    """Return a fresh PyNN simulator module that builds a network.

    Example::

        sim = builder(seed=7)
        sim.setup(timestep=0.1)
        cells = sim.Population(8, sim.IF_cond_alpha(tau_m=10.0), label="cells")
        network = sim.network()

    Args:
        seed: the seed of all random numbers that the script does not seed itself.
        parameters: the values that ``sim.parameter`` returns; others have their defaults.
    """
    return programming_interface(Simulator(State(Seeds(seed).child("network"))), parameters=parameters)
