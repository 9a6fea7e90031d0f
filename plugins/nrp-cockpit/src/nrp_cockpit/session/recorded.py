"""A recording that users watch."""

from __future__ import annotations

import threading
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from nrp_cockpit.session.companion import Companion
from nrp_cockpit.session.recorded_run import FIXED, RecordedRun
from nrp_cockpit.session.reports import Reports
from nrp_cockpit.session.requests import Requests
from nrp_cockpit.session.session import Mode, Session
from nrp_cockpit.streaming.recorded import RecordedStream
from nrp_cockpit.streaming.stored import StoredMessages
from nrp_cockpit.wire.hub import Hub
from nrp_core.cle.pacing import AsFastAsPossible, Paced, Pacing
from nrp_core.errors import CapabilityError, LifecycleError
from nrp_core.findings import Code, Finding, Level
from nrp_core.recording import Recording

CHECKING = "nrp-cockpit-check"
"""The name of the thread that compares a recording with its digests."""


class RecordedSession(Session):
    """Plays a recording and seeks any time in it, without simulation.

    Args:
        folder: the folder of the recording.
        hub: the hub of the clients.
        requests: those of the session that owns the thread, by default this one.

    Attributes:
        messages: the messages of the recording.
        beside: the second recording that follows it, if any.

    Raises:
        ExperimentError: the folder is not a recording.
    """

    def __init__(self, folder: Path, hub: Hub, requests: Requests | None = None) -> None:
        super().__init__(hub, requests)
        self.beside: Companion | None = None
        self.recording = Recording(folder)
        self.messages = StoredMessages(self.recording.file)
        with ExitStack() as opened:
            opened.callback(self.messages.close)
            self._begin_ns, self._end_ns = self.messages.span_ns
            self._now_ns = self._begin_ns
            self.run = RecordedRun(self.recording, self.messages)
            self.stream = RecordedStream(self.messages, hub)
            self._pacing: Pacing = self._paced(self.pace)
            self.reports = RecordedReports(self)
            opened.pop_all()

    @property
    def lead(self) -> RecordedSession:
        """The session whose time it follows; its own by default."""
        return self

    @property
    def now_ns(self) -> int:
        return self._now_ns

    @property
    def end_ns(self) -> int:
        return self._end_ns

    @property
    def timestep_ns(self) -> int:
        return self.run.timestep_ns

    def serve(self) -> None:
        threading.Thread(target=self._check, name=CHECKING, daemon=True).start()
        self.stream.show(self._now_ns)
        super().serve()

    # -- time

    def step(self, n: int = 1) -> None:
        """Advance by a number of recorded steps."""
        self._require_going()
        self._go_to(self._now_ns + n * self.timestep_ns)

    def seek(self, t_s: float) -> None:
        """Go to a time."""
        self._go_to(self._step_at(t_s))

    def reset(self, what: str = "all") -> None:
        """Go back to the beginning.

        Raises:
            CapabilityError: only a part of it is to be reset.
        """
        if what != "all":
            raise CapabilityError(FIXED)
        self._go_to(self._begin_ns)

    def set_pace(self, factor: float | None) -> None:
        """Set how many recorded seconds a wall second holds; None: as fast as it can be read."""
        self._pacing = self._paced(factor)
        self.pace = factor
        self.reports.status()

    def _go_to(self, t_ns: int) -> None:
        """Show a time and pause."""
        self._now_ns = min(max(t_ns, self._begin_ns), self._end_ns)
        self.mode = Mode.FINISHED if self._now_ns == self._end_ns else Mode.PAUSED
        self.stream.show(self._now_ns)
        if self.beside is not None:
            self.beside.go_along()
        self.reports.all()

    # -- the thread

    def _go_from_here(self) -> None:
        self._pacing.start(self._now_ns)

    def _advance(self) -> None:
        """Show the next step when it is due, unless a request comes first."""
        next_ns = min(self._now_ns + self.timestep_ns, self._until_ns, self._end_ns)
        self._pacing.wait(next_ns)
        if self._wanted:
            return
        self._now_ns = next_ns
        with self.hub.together():
            self.stream.take(next_ns)
            if self.beside is not None:
                self.beside.follow()
            if self.hub.listeners:
                self.reports.after_step()
        self._look_whether_there()

    def _idle(self) -> None:
        self.stream.take(self._now_ns)
        self.reports.idle()
        if self.beside is not None:
            self.beside.idle()

    def _end(self) -> None:
        if self.beside is not None:
            self.beside.end()
        self.messages.close()

    def _paced(self, factor: float | None) -> Pacing:
        """Return a pacing whose wait ends with a request."""
        pacing = AsFastAsPossible() if factor is None else Paced(factor, sleep=self._rest)
        pacing.start(self._now_ns)
        return pacing

    # -- integrity

    def _check(self) -> None:
        """Compare the recording with its digests in the background, because that reads all of it."""
        found = integrity_findings(self.recording)
        with suppress(LifecycleError):  # the recording was closed meanwhile
            self.ask(lambda: self._note(found))

    def _note(self, found: list[Finding]) -> None:
        self.run.problems += found
        self.reports.all()


def integrity_findings(recording: Recording) -> list[Finding]:
    """Compare a complete recording with its digests, and return the differences."""
    check = recording.check()
    found = [Finding(Code.NRP284, str(flaw)) for flaw in check.flaws]
    if check.finished:  # without digests the run was killed, which is already reported
        found += [Finding(Code.NRP284, note, Level.NOTE) for note in check.notes]
    return found


class RecordedReports(Reports):
    """Sends the reports of a recording.

    Args:
        session: the session that plays it.
    """

    def __init__(self, session: RecordedSession) -> None:
        super().__init__(session)
        session.hub.offer_json("/cockpit/comparison")
        self._session, self._run = session, session.run
        scenes = session.stream.scenes
        self._experiment = self._run.experiment_data(scenes.entities(session.now_ns) if scenes else [])
        self._functions = self._run.functions_data()
        self._timeline = self._run.timeline_data()

    def _slow(self) -> None:
        super()._slow()
        beside = self._session.beside
        self._say("comparison", {} if beside is None else beside.data())

    def _experiment_data(self) -> dict[str, Any]:
        return self._experiment | {"neighbours": self._run.neighbours}

    def _functions_data(self) -> dict[str, Any]:
        return self._functions

    def _timeline_data(self) -> dict[str, Any]:
        return self._timeline

    def _findings_data(self) -> list[dict[str, Any]]:
        return self._run.findings_data()

    def _status_data(self) -> dict[str, Any]:
        return self._run.status_data() | {"server_ms_per_step": self._session.stream.ms_per_step}
