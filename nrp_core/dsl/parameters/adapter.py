"""The values of the parameters of transfer functions."""

from __future__ import annotations

from typing import Any


class Adapter:
    """The value of a parameter in a transfer function."""

    __slots__ = ()

    def refresh(self, now_ns: int) -> None:
        """Update it right before the function runs."""

    def reset(self) -> None:
        """Return to the state at time 0."""

    def set_active(self, active: bool) -> None:
        """Activate or silence it; settings stay."""

    def release(self) -> None:
        """Release its resources in brain and world."""

    def save(self) -> Any:
        """Return its own state; brain and world save theirs."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""

    def shown(self) -> str:
        """Return the value that the function sees, for reports; empty if it only writes."""
        return ""
