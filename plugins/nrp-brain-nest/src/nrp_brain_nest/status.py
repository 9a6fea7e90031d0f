"""Fast setting of parameters of NEST's nodes: their own ``set`` first looks up each node, at 6 us a node."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def put(nodes: Any, values: Sequence[Mapping[str, object]]) -> None:
    """Set individual values for each node of a collection; lists are faster than arrays."""
    from nest import nestkernel_api  # it is loaded by now

    nestkernel_api.llapi_set_nc_status(nodes._datum, values)
