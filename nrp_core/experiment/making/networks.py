"""The network of an experiment, whatever kind of file it is in.

An entry point in ``nrp_core.networks``, named by a suffix, is a function
``read(path, populations=..., seed=...)`` that returns a :class:`~nrp_core.brain.network.data.Network`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from nrp_core.brain.network.data import Network
from nrp_core.brain.network.picking import Selection
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.registry import Registry

READERS: Registry[Callable[..., Network]] = Registry("nrp_core.networks", "reader of networks")


def network_from(path: Path, *, populations: Mapping[str, Selection] | None = None, seed: int = 0) -> Network:
    """Read a brain script or any other file that a reader is installed for.

    Args:
        path: the file.
        populations: names for neurons of its circuit.
        seed: what its random numbers follow from.

    Raises:
        NetworkError: nobody reads such files, or it cannot be read.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
        CapabilityError: it holds what networks cannot.
    """
    if path.suffix not in READERS.names():
        valid = did_you_mean(path.suffix, READERS.names())
        raise NetworkError(f"no network is read from files that end in '{path.suffix}'{valid}", path=path)
    return READERS.load(path.suffix)(path, populations=populations, seed=seed)
