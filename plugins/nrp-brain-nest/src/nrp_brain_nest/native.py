"""A script of PyNEST as a network: its nodes are populations, whose models and synapses stay in NEST."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from nrp_core.brain import Network, Population, ProcessLock
from nrp_core.network.picking import Selection, with_views

from nrp_brain_nest.cell_types import CONDUCTANCE_CELL, CURRENT_CELL
from nrp_brain_nest.kernel import NAME


@dataclass(frozen=True, repr=False)
class NativeNetwork(Network):
    """The populations of a script that runs in NEST.

    Args:
        script: the script.
    """

    script: Path = field(kw_only=True)

    @cached_property
    def digest(self) -> str:
        """Hash of the populations and of the script."""
        state = hashlib.blake2b(self.script.read_bytes(), digest_size=16)
        state.update(Network.digest.func(self).encode())  # type: ignore[attr-defined]
        return state.hexdigest()


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
    network = NativeNetwork(
        {
            label: Population(label, size, cell, {})
            for (label, size), cell in zip(sizes.items(), cells, strict=True)
        },
        views=built.views,
        remarks=(f"'{path.name}' runs in NEST itself, so no other brain backend can run it",),
        script=path,
    )
    found = with_views(network, populations or {})
    assert isinstance(found, NativeNetwork)
    return found
