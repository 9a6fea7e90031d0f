"""A script of PyNEST as a network: its nodes are populations, whose models and synapses stay in NEST."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nrp_core.brain import Population, ProcessLock
from nrp_core.network.native import NativeNetwork, native_network
from nrp_core.network.picking import Selection

from nrp_brain_nest.cell_types import CONDUCTANCE_CELL, CURRENT_CELL
from nrp_brain_nest.kernel import NAME


def read_native(
    path: Path, *, populations: Mapping[str, Selection] | None = None, seed: int = 0
) -> NativeNetwork:
    """Execute a script of PyNEST up to its first ``Simulate`` and return its neurons as populations.

    Args:
        path: the script.
        populations: names for neurons, counted over all populations in the order of the script's variables.
        seed: the seed of NEST's random numbers, unless the script sets ``rng_seed``.

    Raises:
        NetworkError: the script raises, or ends without ``Simulate``; with file and line.
        LifecycleError: a brain of this process uses NEST.
    """
    from nrp_brain_nest.native_script import execute

    right = ProcessLock(NAME)
    try:
        built = execute(path, seed)
        cells = [CONDUCTANCE_CELL if one else CURRENT_CELL for one in built.is_conductance.values()]
        sizes = {label: len(nodes) for label, nodes in built.nodes.items()}
        built.nest.ResetKernel()
    finally:
        right.release()
    cells_of = zip(sizes.items(), cells, strict=True)
    every = [Population(label, size, cell, {}) for (label, size), cell in cells_of]
    return native_network(path, every, views=built.views, named=populations, simulator="NEST")
