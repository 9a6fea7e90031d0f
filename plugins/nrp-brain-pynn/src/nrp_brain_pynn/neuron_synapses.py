"""PyNN's connections in NEURON, which are sorted by target in an undefined order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from nrp_core.brain import TSODYKS_MARKRAM, FloatArray, Grid, Projection, same_order


def in_order(
    made: list[Any], projection: Projection, short_term: Mapping[str, FloatArray], grid: Grid
) -> list[Any]:
    """Return connections in the order of a projection, None for those of other processes.

    Args:
        made: PyNN's connections, with initial weights or those after plasticity.
        projection: the projection.
        short_term: the parameters of Tsodyks-Markram synapses.
        grid: NEURON's time grid.
    """
    local = np.isin(projection.post_index, [one.postsynaptic_index for one in made])
    ours: dict[str, npt.ArrayLike] = {
        "source": projection.pre_index[local],
        "target": projection.post_index[local],
        "delay": grid.delays(projection.delay_ms[local]),
        "weight": projection.weight[local],
    }
    theirs: dict[str, npt.ArrayLike] = {
        "source": [one.presynaptic_index for one in made],
        "target": [one.postsynaptic_index for one in made],
        "delay": grid.delays(np.array([one.delay for one in made])),
        "weight": [weight_of(one, projection)[0] for one in made],
    }
    for name, values in short_term.items():
        ours[name] = values[local]
        theirs[name] = [getattr(one.weight_adjuster, name) for one in made]
    found: list[Any] = [None] * projection.size
    where = np.flatnonzero(local)
    for mine, other in zip(*same_order(ours, theirs), strict=True):
        found[where[mine]] = made[other]
    return found


def weight_of(connection: Any, projection: Projection) -> Any:
    """Return the place of a connection's weight; for Tsodyks-Markram synapses, of that without depression."""
    short_term = projection.synapse_type == TSODYKS_MARKRAM
    return connection.pre2wa.weight if short_term else connection.nc.weight
