"""A script of Brian2 as a network: its groups are populations, whose cells and synapses stay in Brian2."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nrp_core.brain import Population
from nrp_core.network.native import NativeNetwork, native_network
from nrp_core.network.picking import Selection

from nrp_brain_brian2.options import CELL


def read_native(
    path: Path, *, populations: Mapping[str, Selection] | None = None, seed: int = 0
) -> NativeNetwork:
    """Execute a script of Brian2 up to its first ``run`` and return its groups as populations.

    Args:
        path: the script.
        populations: names for neurons, counted over all groups in the order of the script's variables.
        seed: the seed of Brian2's random numbers, unless the script calls ``seed``.

    Raises:
        NetworkError: the script raises, or ends without ``run``; with file and line.
        CapabilityError: it chooses a device of Brian2 that cannot stop between steps.
    """
    from nrp_brain_brian2.script import execute

    built = execute(path, seed)
    every = [Population(label, len(group), CELL, {}) for label, group in built.groups.items()]
    return native_network(path, every, views=built.views, named=populations, simulator="Brian2")
