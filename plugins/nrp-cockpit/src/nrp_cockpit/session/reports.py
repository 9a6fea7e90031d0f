"""What a session says about itself: a line of state often, the rest when it changes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Protocol

from nrp_cockpit.hearing.hearing import Hearing
from nrp_cockpit.session.described import run_data
from nrp_cockpit.session.findings import finding_data, timeline_data
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.past import Past
from nrp_cockpit.wire.channels import Kind
from nrp_cockpit.wire.hub import Hub
from nrp_core.clock import seconds
from nrp_core.experiment.running.run import Run

STATUS_S, SLOW_S = 0.1, 0.5
"""Wall time between two reports of the state, and of all else."""
_WINDOW_S = 2.0


class Reported(Protocol):
    """A session, as its reports see it."""

    run: Run
    hub: Hub
    hearing: Hearing
    past: Past
    functions: Functions
    doing: str
    pace: float | None
    recording_path: Path | None

    @property
    def state(self) -> str: ...

    @property
    def going_s(self) -> float: ...


class Reports:
    """Sends the reports of a session to its hub.

    Args:
        session: the session.
    """

    def __init__(self, session: Reported) -> None:
        self._session = session
        self._said: dict[str, Any] = {}
        self._status_at = self._slow_at = 0.0
        self._began: tuple[float, int] | None = None
        self._factor = 0.0
        self._spent_s, self._steps = 0.0, 0

    def after_step(self) -> None:
        """Report what is due."""
        self._steps += 1
        now = time.monotonic()
        if now - self._status_at >= STATUS_S and self._session.hub.viewers:
            self.status()
        if now - self._slow_at >= SLOW_S and self._session.hub.viewers:
            self._slow_at = now
            self._slow()

    def idle(self) -> None:
        """Report what is due while nothing runs."""
        self._began = None
        if time.monotonic() - self._status_at >= STATUS_S * 5:
            self.status()

    def all(self) -> None:
        """Report everything."""
        self._say("experiment", run_data(self._session.run))
        self._slow()
        self.status()

    def timeline(self) -> None:
        """Report what has happened."""
        session = self._session
        self._say("timeline", timeline_data(session.run, session.run.result(), session.past.shown))

    def status(self) -> None:
        """Report the state."""
        session, run = self._session, self._session.run
        now = self._status_at = time.monotonic()
        result = run.result()
        share = result.time_share
        self._say("status", {
            "state": session.state,
            "doing": session.doing or None,
            "t_s": run.now_s,
            "wall_s": result.wall_time_s + session.going_s,
            "real_time_factor": self._measured(now, run.loop.now_ns),
            "pace": session.pace,
            "recording": self._recording(),
            "viewers": session.hub.viewers,
            "dropped": session.hub.dropped,
            "server_ms_per_step": session.hearing.ms_per_step,
            "share": {
                "brain": share["brain"], "world": share["world"],
                "functions": share["transfer_functions"], "loop": share["engine"],
            },
            "error": self._error(),
            "passed": result.passed,
            "complete": result.complete,
        })  # fmt: skip

    def log(self, level: str, text: str) -> None:
        """Report a line of text."""
        hub = self._session.hub
        hub.tell(
            "/cockpit/log", {"t_s": self._session.run.now_s, "level": level, "text": text}, kind=Kind.EVERY
        )

    def _slow(self) -> None:
        session = self._session
        self._say("functions", session.functions.data())
        self.timeline()
        self._say("findings", [finding_data(each) for each in session.run.problems])

    def _say(self, name: str, value: Any) -> None:
        """Send a report if it says something new."""
        if self._said.get(name) != value:
            self._said[name] = value
            self._session.hub.tell(f"/cockpit/{name}", value, self._session.run.loop.now_ns)

    def _measured(self, now: float, t_ns: int) -> float:
        """Return how fast the run is beside the wall clock, over the last seconds."""
        if self._session.state != "running":
            self._began = None
            return self._factor
        if self._began is None or t_ns < self._began[1]:
            self._began = now, t_ns
            return self._factor
        began, began_ns = self._began
        if now - began > STATUS_S:
            self._factor = seconds(t_ns - began_ns) / (now - began)
        if now - began > _WINDOW_S:
            self._began = now, t_ns
        return self._factor

    def _recording(self) -> dict[str, Any] | None:
        path = self._session.recording_path
        if path is None:
            return None
        mcap = path / "recording.mcap"
        return {"path": str(path), "bytes": mcap.stat().st_size if mcap.is_file() else 0}

    def _error(self) -> dict[str, Any] | None:
        run = self._session.run
        error = run.error
        if error is None:
            return None
        failure = run.loop.failures[-1] if run.loop.failures else None
        place = (None, None) if failure is None else (str(failure.path), failure.line)
        return {"message": str(error), "file": place[0], "line": place[1]}
