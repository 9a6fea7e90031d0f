"""The connectors that only sPyNNaker has."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

import numpy as np
from pyNN import connectors

from nrp_core.brain.pynn.connectors import Connector
from nrp_core.brain.pynn.invalid import WrongKindError


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
