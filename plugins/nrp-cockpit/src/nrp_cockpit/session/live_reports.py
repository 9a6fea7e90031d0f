"""The reports of a session about a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

from nrp_cockpit.session.companion import Companion
from nrp_cockpit.session.described import run_data
from nrp_cockpit.session.findings import finding_data, timeline_data
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.past import Past
from nrp_cockpit.session.reports import Reported, Reports, shares_data
from nrp_cockpit.streaming.live import LiveStream
from nrp_core.experiment import Run


class LiveReported(Reported, Protocol):
    """The interface of a session with a run for its reports."""

    run: Run
    stream: LiveStream
    past: Past
    functions: Functions
    recording_path: Path | None
    recorded_path: Path | None
    beside: Companion | None

    @property
    def wall_s(self) -> float: ...


class LiveReports(Reports):
    """Sends the reports of a run.

    Args:
        session: the session that owns the run.
    """

    def __init__(self, session: LiveReported) -> None:
        super().__init__(session)
        self._session = session
        session.hub.offer_json("/cockpit/comparison")
        self._result = session.run.result()
        self._refused: dict[str, str] = {}

    def _slow(self) -> None:
        super()._slow()
        self._look_for_losses()
        self._say("comparison", {} if self._session.beside is None else self._session.beside.data())

    def _look_for_losses(self) -> None:
        """Report that the run cannot be saved any more, or that it can again after it was opened anew."""
        refused = self._session.past.refused
        if refused != self._refused:
            if "snapshot" in refused.keys() - self._refused.keys():
                self.log("warning", f"no more snapshots can be taken: {refused['snapshot']}")
            self._refused = refused
            self._say("experiment", self._experiment_data())

    def _experiment_data(self) -> dict[str, Any]:
        return run_data(self._session.run, self._refused)

    def _functions_data(self) -> dict[str, Any]:
        return self._session.functions.data()

    def _timeline_data(self) -> dict[str, Any]:
        run, past = self._session.run, self._session.past
        self._result = result = run.result()  # too slow for each report of the state
        return timeline_data(run.experiment, result.events, result.criteria, result.failures, past.data())

    def _findings_data(self) -> list[dict[str, Any]]:
        in_place = self._session.functions.drafts.in_place
        return [in_place(finding_data(each)) for each in self._result.problems]

    def _status_data(self) -> dict[str, Any]:
        session, result = self._session, self._result
        return {
            "wall_s": session.wall_s,
            "recording": self._recording(),
            "recorded": None if session.recorded_path is None else str(session.recorded_path),
            "server_ms_per_step": session.stream.ms_per_step,
            "share": shares_data(session.run.loop.account.shares()),
            "error": self._error(),
            "passed": result.passed,
            "complete": result.complete,
        }  # fmt: skip

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
        shown = {"message": str(error), "file": place[0], "line": place[1]}
        return dict(self._session.functions.drafts.in_place(shown))
