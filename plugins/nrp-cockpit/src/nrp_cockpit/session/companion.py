"""The interface of a companion of a session."""

from __future__ import annotations

from typing import Any, Protocol


class Companion(Protocol):
    """Follows the time of a session."""

    def follow(self) -> None:
        """Follow to the time of the session after a step."""

    def go_from_here(self) -> None:
        """Note that the session continues from here, possibly differently from before."""

    def go_along(self) -> None:
        """Follow to the time that the session went to, back or forward."""

    def idle(self) -> None:
        """Do periodic work while paused."""

    def end(self) -> None:
        """Close, and release all resources."""

    def data(self) -> dict[str, Any]:
        """Return the difference of the two for the page."""
