"""The expected number of synapses of a connector, estimated before any is drawn."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import Any, Final

import numpy as np
from pyNN import connectors
from pyNN.parameters import LazyArray

from nrp_core.network.indices import index_type
from nrp_core.network.memory import free_bytes, require_memory

_COLUMNS: Final = 20
"""The number of sampled postsynaptic cells, where the probability differs between pairs."""
_BYTES_PER_VALUE: Final = 8
"""Memory for each parameter that differs between synapses; parts are freed as they are joined."""


def require_room(connector: Any, projection: Any) -> None:
    """Check that the synapses of a connector will fit into memory.

    Raises:
        NetworkError: they do not fit; the message has the counts.
    """
    n_pre, n_post = projection.pre.size, projection.post.size
    values = projection.synapse_type.parameter_space.items()
    own = sum(not value.is_homogeneous for _, value in values)
    # one index of each synapse, both in parts and joined; the other index ascends
    each = 2 * np.dtype(index_type(n_pre)).itemsize + own * _BYTES_PER_VALUE
    free = free_bytes()
    if free is None or (n_pre * n_post * each <= free and not _repeats(connector)):
        return
    expected = expected_synapses(connector, projection)
    name = type(connector).__name__
    what = f"{name} from {n_pre} to {n_post} cells makes about {expected:.3g} synapses, which"
    require_memory(f"projection '{projection.label}'", expected * each, what)


def expected_synapses(connector: Any, projection: Any) -> float:
    """Return the mean number of synapses that a connector makes, or 0 if it is unknown."""
    n_pre, n_post = projection.pre.size, projection.post.size
    given = getattr(connector, "n", None)
    n: float = given if isinstance(given, (int, float)) else 0.0
    match connector:
        case connectors.AllToAllConnector():
            return float(n_pre * n_post)
        case connectors.OneToOneConnector():
            return float(min(n_pre, n_post))
        case connectors.FixedProbabilityConnector():
            return float(connector.p_connect * n_pre * n_post)
        case connectors.FixedNumberPreConnector():
            return float(n * n_post)
        case connectors.FixedNumberPostConnector():
            return float(n * n_pre)
        case connectors.FixedTotalNumberConnector():
            return float(n)
        case connectors.DistanceDependentProbabilityConnector() | connectors.IndexBasedProbabilityConnector():
            return _by_columns(_probabilities(connector, projection), n_pre, n_post)
        case connectors.SmallWorldConnector():
            near = connector._generate_distance_map(projection) < connector.degree
            kept = np.inf if connector.n_connections is None else connector.n_connections * n_pre
            return min(_by_columns(near, n_pre, n_post), kept)
    return 0.0


def _probabilities(connector: Any, projection: Any) -> LazyArray:
    """Return the probability of each pair of cells."""
    if isinstance(connector, connectors.DistanceDependentProbabilityConnector):
        return connector.distance_function(connector._generate_distance_map(projection))
    expression = copy(connector.index_expression)
    expression.projection = projection
    return LazyArray(expression, projection.shape)


def _by_columns(probabilities: LazyArray, n_pre: int, n_post: int) -> float:
    """Return an estimate of the sum of a matrix of probabilities from some of its columns.

    Samples whole columns, since randomly sampled pairs would rarely include nearby cells.
    """
    sums = [np.clip(column, 0.0, 1.0).sum() for column in _columns(probabilities, n_pre, n_post)]
    return float(np.mean(sums)) * n_post if sums else 0.0


def _columns(probabilities: LazyArray, n_pre: int, n_post: int) -> Iterator[Any]:
    everyone, n = np.arange(n_pre), min(n_post, _COLUMNS)
    for j in ((np.arange(n) + 0.5) * n_post / max(n, 1)).astype(int):
        yield probabilities[everyone, int(j)]


def _repeats(connector: Any) -> bool:
    """Whether a connector may make several synapses between two cells."""
    return isinstance(connector, (connectors.FixedNumberConnector, connectors.FixedTotalNumberConnector))
