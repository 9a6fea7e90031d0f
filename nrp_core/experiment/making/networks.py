"""The network of an experiment, from any kind of file.

An entry point in ``nrp_core.networks``, named by a suffix, is a function
``read(path, populations=..., seed=...)`` that returns a :class:`~nrp_core.brain.network.data.Network`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from nrp_core.brain.network.data import Network
from nrp_core.brain.network.picking import Selection
from nrp_core.errors import NetworkError, UnknownBackendError, did_you_mean
from nrp_core.registry import Registry

READERS: Registry[Callable[..., Network]] = Registry("nrp_core.networks", "reader of networks")


def network_from(
    path: Path,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,
    parameters: Mapping[str, object] | None = None,
) -> Network:
    """Read a brain script or any other file with an installed reader.

    Args:
        path: the file.
        populations: names for neurons of its circuit.
        seed: the seed of its random numbers.
        parameters: values of the parameters that a script declares; only such a reader gets them.

    Raises:
        NetworkError: there is no reader for such files, or it cannot be read.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
        CapabilityError: it contains elements that networks do not support.
    """
    if path.suffix not in READERS.names() and not READERS.distribution_with(path.suffix):
        valid = did_you_mean(path.suffix, READERS.names())
        raise NetworkError(f"no network is read from files that end in '{path.suffix}'{valid}", path=path)
    try:
        read = READERS.load(path.suffix)
    except UnknownBackendError as error:
        raise NetworkError(str(error), path=path) from error
    given = {"parameters": parameters} if parameters else {}
    return read(path, populations=populations, seed=seed, **given)
