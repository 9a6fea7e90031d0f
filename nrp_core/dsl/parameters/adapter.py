"""The values of the parameters of transfer functions."""

from __future__ import annotations

from typing import Any


class Adapter:
    """The value of a parameter in a transfer function."""

    __slots__ = ()

    def refresh(self, now_ns: int) -> None:
        """Update it just before the function runs."""

    def has_news(self) -> bool | None:
        """Return whether something came that the function has not seen; None: it triggers no function."""
        return None

    def reset(self) -> None:
        """Return to the state at time 0."""

    def set_active(self, active: bool) -> None:
        """Activate or silence it; it keeps its settings."""

    def release(self) -> None:
        """Release its resources in brain and world."""

    def save(self) -> Any:
        """Return its own state; brain and world save theirs."""
        return None

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""

    def shown(self) -> str:
        """Return the value that the function reads as text, for reports; empty if it only writes."""
        return ""
