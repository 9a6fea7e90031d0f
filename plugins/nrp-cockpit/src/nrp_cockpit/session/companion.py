"""What goes with a session, as the session sees it."""

from __future__ import annotations

from typing import Any, Protocol


class Companion(Protocol):
    """Goes wherever the time of a session goes."""

    def follow(self) -> None:
        """Come to where the session is after a step."""

    def go_from_here(self) -> None:
        """Note that the session goes on from here, maybe another way than before."""

    def go_along(self) -> None:
        """Go to where the session has gone, back or forward."""

    def idle(self) -> None:
        """Do what is due while nothing goes on."""

    def end(self) -> None:
        """End, and release everything."""

    def data(self) -> dict[str, Any]:
        """Return how the two differ, as the page shows it."""
