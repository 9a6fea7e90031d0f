"""The reports of a session: its state often, the rest when it changes."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Protocol

from nrp_cockpit.wire.channels import Kind
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.playback import Playback
from nrp_core.clock import seconds

STATUS_S, SLOW_S = 0.1, 0.5
"""Wall time between two reports of the state, and of all else."""
_WINDOW_S = 2.0
_SHARES = {"brain": "brain", "world": "world", "functions": "transfer_functions", "loop": "engine"}


def shares_data(shares: Mapping[str, float]) -> dict[str, float] | None:
    """Return the shares of the parts of a step in the time of a run; None before its first step."""
    return {name: shares.get(key, 0.0) for name, key in _SHARES.items()} if any(shares.values()) else None


class Reported(Protocol):
    """The interface of a session for its reports."""

    hub: Hub
    doing: str
    pace: float | None

    @property
    def state(self) -> str: ...

    @property
    def now_ns(self) -> int: ...

    @property
    def end_ns(self) -> int: ...


class Reports(ABC):
    """Sends the reports of a session to its hub.

    Args:
        session: the session.
    """

    def __init__(self, session: Reported) -> None:
        self._reported = session
        self._said: dict[str, Any] = {}
        self._status_at = self._slow_at = 0.0
        self._began: tuple[float, int] | None = None
        self._factor: float | None = None
        for name in ("experiment", "status", "functions", "timeline", "findings"):
            session.hub.offer_json(f"/cockpit/{name}")
        session.hub.offer_json("/cockpit/log", Kind.EVERY)

    def after_step(self) -> None:
        """Send the reports that are due."""
        now = time.monotonic()
        if now - self._status_at >= STATUS_S:
            self.status()
        if now - self._slow_at >= SLOW_S:
            self._slow_at = now
            self._slow()

    def idle(self) -> None:
        """Send the reports that are due while paused."""
        self._began = None
        if time.monotonic() - self._status_at >= STATUS_S * 5:
            self.status()

    def all(self) -> None:
        """Report everything."""
        self._say("experiment", self._experiment_data())
        self.progress()

    def progress(self) -> None:
        """Report everything but the description of the session, which is slow and rarely changes."""
        self._slow()
        self.status()

    def timeline(self) -> None:
        """Report the timeline."""
        self._say("timeline", self._timeline_data())

    def status(self) -> None:
        """Report the state."""
        session, now = self._reported, time.monotonic()
        self._status_at = now
        session.hub.play_back(Playback(session.state, session.now_ns, session.end_ns, session.pace))
        self._say("status", {
            "state": session.state,
            "doing": session.doing or None,
            "t_s": seconds(session.now_ns),
            "real_time_factor": self._measured(now, session.now_ns),
            "pace": session.pace,
            "viewers": session.hub.viewers,
            "controllers": session.hub.controllers,
            "dropped": session.hub.dropped,
            **self._status_data(),
        })  # fmt: skip

    def log(self, level: str, text: str) -> None:
        """Report a line of text."""
        line = {"t_s": seconds(self._reported.now_ns), "level": level, "text": text}
        self._reported.hub.send_json("/cockpit/log", line, self._reported.now_ns)

    # -- the contents, in the shapes of the page's state/types.ts

    @abstractmethod
    def _experiment_data(self) -> dict[str, Any]:
        """Return the description of the session and its possibilities."""

    @abstractmethod
    def _functions_data(self) -> dict[str, Any]:
        """Return the transfer functions and their files."""

    @abstractmethod
    def _timeline_data(self) -> dict[str, Any]:
        """Return past and future events."""

    @abstractmethod
    def _findings_data(self) -> list[dict[str, Any]]:
        """Return problems and notes."""

    @abstractmethod
    def _status_data(self) -> dict[str, Any]:
        """Return the part of the state that only this kind of session has."""

    # -- sending

    def _slow(self) -> None:
        self._say("functions", self._functions_data())
        self.timeline()
        self._say("findings", self._findings_data())

    def _say(self, name: str, value: Any) -> None:
        """Send a report if it has changed."""
        if self._said.get(name) != value:
            self._said[name] = value
            self._reported.hub.send_json(f"/cockpit/{name}", value, self._reported.now_ns)

    def _measured(self, now: float, t_ns: int) -> float | None:
        """Return the speed of time relative to the wall clock over the last seconds; None in a pause."""
        if self._reported.state != "running":
            self._began = self._factor = None
            return None
        if self._began is None or t_ns < self._began[1]:
            self._began = now, t_ns
            return self._factor
        began, began_ns = self._began
        if now - began > STATUS_S:
            self._factor = seconds(t_ns - began_ns) / (now - began)
        if now - began > _WINDOW_S:
            self._began = now, t_ns
        return self._factor
