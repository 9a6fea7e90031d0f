"""A second run in step with that of a session: a branch of it, or the experiment on other engines."""

from __future__ import annotations

from typing import Any

from nrp_cockpit.session.difference import Difference
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.session.session import Mode
from nrp_cockpit.wire.hub import Hub
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError
from nrp_core.experiment import Run


class Beside(LiveSession):
    """A run that follows the time of another run; everything else is independent.

    Args:
        run: an open run, at the time from which it follows.
        hub: the hub of its clients.
        lead: the session that it follows, which owns the thread.
        label: its name on the page.
        lead_label: the name of the leading run on the page.
        functions: its transfer functions; by default those on disk.

    Attributes:
        difference: the difference between the two.
    """

    def __init__(
        self,
        run: Run,
        hub: Hub,
        lead: LiveSession,
        label: str,
        lead_label: str,
        functions: Functions | None = None,
    ) -> None:
        self.lead, self.label, self.lead_label = lead, label, lead_label
        super().__init__(run, hub, lead.requests, functions)
        self.difference = Difference(lead.run, run)
        self._since_ns = run.loop.now_ns
        self._unpaced_always()
        self.difference.update()

    @property
    def state(self) -> str:
        """The mode of the lead, unless this run has failed."""
        return str(Mode.FAILED if self.mode is Mode.FAILED else self.lead.mode)

    def follow(self) -> None:
        """Run to the time of the lead, after a step of it."""
        until_ns = self.lead.now_ns
        if self.mode is not Mode.FAILED and self.now_ns < until_ns:
            self.mode = Mode.RUNNING
            self._guarded(lambda: self._run_through(until_ns))
        if self.now_ns == until_ns:
            self.difference.update()

    def go_from_here(self) -> None:
        """Forget the later past, because the lead continues from here."""
        self.past.forget_after(self.now_ns)

    def go_along(self) -> None:
        """Go to the time of the lead, but not before the beginning of this run."""
        t_ns = max(self.lead.now_ns, self._since_ns)
        if t_ns != self.now_ns or self.mode is Mode.FAILED:
            try:
                self.seek(seconds(t_ns))
            except CapabilityError:  # this run keeps no snapshots
                self.reset()
                self._guarded(lambda: self._run_through(t_ns))
        self.difference.cut(t_ns)
        self.reports.all()

    def idle(self) -> None:
        """Do periodic work while paused."""
        self._idle()

    def end(self) -> None:
        """Close the run and release its engines."""
        self._end()
        self.run.close()

    def data(self) -> dict[str, Any]:
        """Return the difference of the two runs and their names."""
        return {"labels": [self.lead_label, self.label], **self.difference.data()}
