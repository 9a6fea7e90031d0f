"""The connectors that only sPyNNaker has."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

import numpy as np
from pyNN import connectors

from nrp_core.brain.pynn.connectors import Connector
from nrp_core.brain.pynn.invalid import InvalidSynapseError, WrongKindError
from nrp_core.errors import CapabilityError


class OneToOneOffsetConnector(Connector, connectors.MapConnector):
    """Each cell to the one whose index is larger by an offset.

    Args:
        offset: the difference of the indices.
        wrap: whether the target's cells form a ring; else cells beyond its ends are left out.
    """

    parameter_names = ("offset", "wrap")

    def __init__(self, offset: int, wrap: bool = False, **options: Any) -> None:
        super().__init__(**options)
        if not isinstance(offset, (int, np.integer)):
            raise WrongKindError(f"OneToOneOffsetConnector: offset is {offset!r}; it must be a whole number")
        self.offset, self.wrap = int(offset), bool(wrap)

    def _connect(self, projection: Any) -> None:
        pre = np.arange(projection.pre.size)
        post = pre + self.offset
        if self.wrap:
            post %= projection.post.size
        inside = (post >= 0) & (post < projection.post.size)
        self._connect_pairs(projection, pre[inside], post[inside])


class AllButMeConnector(Connector, connectors.MapConnector):
    """Each cell to all others of its group, for groups of which one cell wins.

    Args:
        n_neurons_per_group: the number of cells of a group, by default all.
        weights: not supported.
    """

    parameter_names = ("n_neurons_per_group",)

    def __init__(
        self, n_neurons_per_group: int | None = None, weights: Any = None, safe: bool = True,
        verbose: bool = False, callback: Any = None,
    ) -> None:  # fmt: skip
        super().__init__(safe=safe, callback=callback)
        if weights is not None:
            raise CapabilityError(
                "AllButMeConnector: weights are not supported: their order is known to the machine alone; "
                "FromListConnector takes synapses one by one"
            )
        n = n_neurons_per_group
        if n is not None and not (isinstance(n, (int, np.integer)) and n > 0):
            raise WrongKindError(
                f"AllButMeConnector: n_neurons_per_group is {n!r}; it must be a whole number from 1 on"
            )
        self.n_neurons_per_group = n

    def _connect(self, projection: Any) -> None:
        size, n = projection.pre.size, self.n_neurons_per_group or projection.pre.size
        if projection.post.size != size or size % n:
            raise InvalidSynapseError(
                f"projection '{projection.label}': AllButMeConnector joins populations of one size, a "
                f"multiple of n_neurons_per_group, not {size} and {projection.post.size} in groups of {n}"
            )
        post, other = np.divmod(np.arange(size * n), n)
        pre = post // n * n + other
        self._connect_pairs(projection, pre[pre != post], post[pre != post])
