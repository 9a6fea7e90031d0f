"""A session: simulated time under the control of clients, from a live run or a recording."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from enum import StrEnum
from typing import Any

from nrp_cockpit.session.reports import Reports
from nrp_cockpit.session.requests import Requests
from nrp_cockpit.wire.hub import Hub
from nrp_core.clock import from_seconds, seconds
from nrp_core.errors import LifecycleError

_REST_S = 0.1
"""Wall time between two checks for new subscriptions while the session idles, s."""


class Mode(StrEnum):
    """The activity of a session."""

    PAUSED = "paused"
    RUNNING = "running"
    FINISHED = "finished"
    FAILED = "failed"
    BUSY = "busy"


class Session(ABC):
    """Owns a thread in which time advances unless it is paused, and which answers requests in between.

    The thread of :meth:`serve` handles requests between two steps; services wait for their answer.

    Args:
        hub: of the clients.
        requests: those of the session that owns the thread, by default this one.

    Attributes:
        requests: the calls that wait.
        mode: its activity.
        doing: the task in words while it is busy.
        pace: simulated seconds per wall second at most; None: as fast as possible.
        reports: its status reports; each subclass sets it.
    """

    reports: Reports

    def __init__(self, hub: Hub, requests: Requests | None = None) -> None:
        self.hub = hub
        self.mode, self.doing = Mode.PAUSED, ""
        self.pace: float | None = 1.0
        self._until_ns = 0
        self.requests = Requests() if requests is None else requests
        hub.wake = self.requests.wake

    @property
    def state(self) -> str:
        """Its activity, in one word."""
        return str(self.mode)

    @property
    @abstractmethod
    def now_ns(self) -> int:
        """The simulated time."""

    @property
    @abstractmethod
    def end_ns(self) -> int:
        """The simulated time at which it ends."""

    @property
    @abstractmethod
    def timestep_ns(self) -> int:
        """The simulated time of a step."""

    def serve(self) -> None:
        """Run and answer until :meth:`close` or Ctrl-C, in the thread that owns the session."""
        requests = self.requests
        try:
            self.reports.all()
            while not requests.is_closed:
                if self.mode is Mode.RUNNING:
                    self._advance()
                else:
                    self._idle()
                    requests.idle(_REST_S)
                requests.answer()
        except KeyboardInterrupt:
            pass
        finally:
            requests.close()
            requests.refuse()
            self._end()

    def close(self) -> None:
        """End :meth:`serve` after the current step; any thread may call this."""
        self.requests.close()

    def ask(self, call: Callable[[], Any], doing: str = "") -> Any:
        """Have the session's thread make a call between two steps; return its result or raise its error.

        Args:
            call: the call.
            doing: the text that the page shows during a long call.
        """

        def busy() -> Any:
            before, self.mode, self.doing = self.mode, Mode.BUSY, doing
            self.reports.status()
            try:
                return call()
            finally:
                self.doing = ""
                if self.mode is Mode.BUSY:
                    self.mode = before
                self.reports.status()

        return self.requests.ask(busy if doing else call)

    # -- running

    def play(self) -> None:
        """Run to the end."""
        self._play_to(self.end_ns)

    def run_to(self, t_s: float) -> None:
        """Run to a time."""
        self._play_to(min(self._step_at(t_s), self.end_ns))

    def pause(self) -> None:
        """Stop after the current step."""
        if self.mode is Mode.RUNNING:
            self.mode = Mode.PAUSED
        self.reports.progress()

    def step_back(self) -> None:
        """Return to the step before this one."""
        self.seek(seconds(self.now_ns - self.timestep_ns))

    @abstractmethod
    def step(self, n: int = 1) -> None:
        """Take some steps."""

    @abstractmethod
    def seek(self, t_s: float) -> None:
        """Go to a time, back or forward, and stay there."""

    @abstractmethod
    def reset(self, what: str = "all") -> None:
        """Return everything, or the part ``what``, to the beginning."""

    @abstractmethod
    def set_pace(self, factor: float | None) -> None:
        """Limit the simulated seconds per wall second; None: as fast as possible."""

    def _play_to(self, until_ns: int) -> None:
        self._require_going()
        if until_ns <= self.now_ns:
            raise LifecycleError(f"the run is already at {seconds(self.now_ns):g} s")
        self._go_from_here()
        self._until_ns, self.mode = until_ns, Mode.RUNNING
        self.reports.progress()

    def _require_going(self) -> None:
        if self.mode in (Mode.FINISHED, Mode.FAILED):
            raise LifecycleError("the run has ended: step back or reset")

    def _step_at(self, t_s: float) -> int:
        """Return the time of the step at or after a time."""
        return -(-from_seconds(t_s) // self.timestep_ns) * self.timestep_ns

    def _look_whether_there(self) -> None:
        """Stop if the target time is reached."""
        if self.mode is Mode.RUNNING and self.now_ns >= min(self._until_ns, self.end_ns):
            self._stop_here()

    def _stop_here(self) -> None:
        """Stop at the current time and report that."""
        self.mode = Mode.FINISHED if self.now_ns >= self.end_ns else Mode.PAUSED
        self.reports.progress()

    # -- the thread

    @property
    def _wanted(self) -> bool:
        """Whether a caller waits for an answer or for the end."""
        return self.requests.wanted

    def _rest(self, wall_s: float) -> None:
        """Wait, at most until a request arrives."""
        self.requests.wait(wall_s)

    @abstractmethod
    def _go_from_here(self) -> None:
        """Prepare to continue from the current time."""

    @abstractmethod
    def _advance(self) -> None:
        """Run, at most until a request arrives."""

    @abstractmethod
    def _idle(self) -> None:
        """Do the regular work of an idle session."""

    @abstractmethod
    def _end(self) -> None:
        """End everything."""
