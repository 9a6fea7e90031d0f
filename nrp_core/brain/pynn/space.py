"""PyNN's space, whose axes are checked where they are named."""

from __future__ import annotations

from typing import Any

from pyNN import space

from nrp_core.errors import NetworkError


class Space(space.Space):  # type: ignore[misc]  # PyNN has no types
    """Distances between cells.

    Raises:
        NetworkError: there are no such axes.
    """

    def __init__(self, axes: str | None = None, *arguments: Any, **named: Any) -> None:
        known = [name for name in self.AXES if name is not None]
        if axes is not None and axes not in known:
            raise NetworkError(f"Space: axes is one of {', '.join(known)}, not {axes!r}")
        super().__init__(axes, *arguments, **named)
