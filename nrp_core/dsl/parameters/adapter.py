"""What a transfer function is given for a parameter."""

from __future__ import annotations

from typing import Any


class Adapter:
    """What a transfer function finds in a parameter."""

    __slots__ = ()

    def refresh(self, now_ns: int) -> None:
        """Take in what is new, right before the function runs."""

    def reset(self) -> None:
        """Return to the state at time 0."""

    def set_active(self, active: bool) -> None:
        """Work or fall silent; what is set stays."""

    def release(self) -> None:
        """Give back what was taken from brain and world."""

    def save(self) -> Any:
        """Return its own state; brain and world save theirs."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""

    def shown(self) -> str:
        """Return what the function sees, for reports; empty where it only writes."""
        return ""
