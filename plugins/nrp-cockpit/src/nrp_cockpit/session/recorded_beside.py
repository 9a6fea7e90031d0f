"""A second recording, shown beside the first one at the same time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrp_cockpit.session.controls import asked, prefixed, services_of_recording
from nrp_cockpit.session.recorded import RecordedSession
from nrp_cockpit.session.recorded_difference import RecordedDifference
from nrp_cockpit.wire.hub import Hub, Services
from nrp_core.errors import ExperimentError, LifecycleError, did_you_mean


class RecordedBeside(RecordedSession):
    """A recording that follows the time of another one, up to its own end.

    Args:
        folder: the folder of the recording.
        hub: the hub of its clients.
        lead: the session that it follows, which owns the thread.
    """

    def __init__(self, folder: Path, hub: Hub, lead: RecordedSession) -> None:
        super().__init__(folder, hub, lead.requests)
        self._lead = lead
        self._difference = RecordedDifference(lead.recording, self.recording)
        self._labels = [lead.recording.folder.name, folder.name]

    @property
    def lead(self) -> RecordedSession:
        return self._lead

    @property
    def state(self) -> str:
        """The mode of the lead."""
        return str(self._lead.mode)

    def follow(self) -> None:
        """Play to the time of the lead."""
        self._now_ns = self._common_ns
        self.stream.take(self._now_ns)
        if self.hub.listeners:
            self.reports.after_step()

    def go_from_here(self) -> None:
        """Do nothing: a recording has no other future."""

    def go_along(self) -> None:
        """Show the time of the lead."""
        self._now_ns = self._common_ns
        self.stream.show(self._now_ns)
        self.reports.all()

    def idle(self) -> None:
        """Do periodic work while paused."""
        self._idle()

    def end(self) -> None:
        """Close the recording."""
        self._end()

    def data(self) -> dict[str, Any]:
        """Return the difference of the two and their names."""
        return {"labels": self._labels, **self._difference.data(self._common_ns)}

    @property
    def _common_ns(self) -> int:
        return min(max(self._lead.now_ns, self._begin_ns), self._end_ns)


def open_beside(session: RecordedSession, folder: Path) -> None:
    """Open a second recording beside that of a session.

    Raises:
        ExperimentError: the folder is not a recording.
        LifecycleError: a second one is already open.
    """
    if session.beside is not None:
        raise LifecycleError("a second recording is already open: close it first")
    hub = session.hub.open_second()
    try:
        beside = RecordedBeside(folder, hub, session)
    except BaseException:
        session.hub.beside = None
        raise
    hub.services = services_of_recording(beside)
    session.beside = beside
    beside.go_along()
    session.reports.all()


def with_beside(services: Services, session: RecordedSession) -> Services:
    """Return the services of a recording, with those that open and close another one of the same folder."""

    def compare(recording: str) -> None:
        neighbours = session.run.neighbours
        if recording not in neighbours:
            known = did_you_mean(recording, neighbours)
            raise ExperimentError(f"there is no recording '{recording}' beside this one{known}")
        open_beside(session, session.recording.folder.absolute().parent / recording)

    def part() -> None:
        if session.beside is None:
            raise LifecycleError("there is no second recording")
        beside, session.beside, session.hub.beside = session.beside, None, None
        beside.end()
        session.reports.all()

    more = {
        "compare": asked(session, compare, "reading both recordings"),
        "part": asked(session, part, "closing the second recording"),
    }
    return Services({**services.steering, **prefixed(more, {}).steering}, services.watching)
