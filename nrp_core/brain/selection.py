"""Neurons by their global ids, checked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray
from nrp_core._support.checked_arguments import require_kind
from nrp_core.brain.network.data import Network
from nrp_core.errors import NeuronSelectionError


def selected(network: Network, neurons: npt.ArrayLike) -> IntArray:
    """Return global ids.

    Raises:
        NeuronSelectionError: a neuron does not exist, or is not given by a whole number.
    """
    given = np.asarray(neurons)
    if given.size and given.dtype.kind not in "iu":
        raise NeuronSelectionError(
            f"neurons are given by their global ids, whole numbers, not by {neurons!r:.60}; "
            "network.neurons(NAME) returns those of a population"
        )
    ids = np.atleast_1d(given.astype(np.int64, copy=False))
    if ids.size and not (ids.min() >= 0 and ids.max() < network.size):
        raise NeuronSelectionError(f"neuron ids lie in 0..{network.size - 1}, not {ids.tolist()}")
    return ids


def require_spec(spec: object, kind: type, name: str) -> None:
    """Check that a device is described as one that drives neurons, or as one that reads them.

    Raises:
        ArgumentError: its name is not a text.
        NeuronSelectionError: it is not.
    """
    require_kind("a device", "name", str, name)
    if not isinstance(spec, kind):
        raise NeuronSelectionError(f"the device '{name}' is {spec!r:.60}, not a {kind.__name__}")


def drivable(network: Network, neurons: npt.ArrayLike, name: str) -> IntArray:
    """Return global ids of cells that a device of some name can drive.

    Raises:
        NeuronSelectionError: a neuron does not exist, or is a source itself.
    """
    ids = selected(network, neurons)
    if (label := source_among(network, ids)) is not None:
        raise NeuronSelectionError(
            f"'{name}' cannot drive neurons of population '{label}', which only emit spikes"
        )
    return ids


def source_among(network: Network, ids: IntArray) -> str | None:
    """Return the first population of source cells that some of these neurons belong to."""
    for label, population in network.populations.items():
        first = network.offsets[label]
        if population.is_source and ((ids >= first) & (ids < first + population.size)).any():
            return label
    return None
