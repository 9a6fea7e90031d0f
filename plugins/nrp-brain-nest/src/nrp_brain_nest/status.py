"""Setting NEST's nodes in the loop: their own ``set`` first asks each node where it lives, at 6 us a node."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def put(nodes: Any, values: Sequence[Mapping[str, object]]) -> None:
    """Set each node of a collection to values of its own; lists are taken over faster than arrays."""
    from nest import nestkernel_api  # by now it is loaded

    nestkernel_api.llapi_set_nc_status(nodes._datum, values)
