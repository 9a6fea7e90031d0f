"""A time that people watch and steer, whether it is computed or was recorded."""

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
"""Wall time between two looks at what is heard, while nothing goes on."""


class Mode(StrEnum):
    """What a session does."""

    PAUSED = "paused"
    RUNNING = "running"
    FINISHED = "finished"
    FAILED = "failed"
    BUSY = "busy"


class Session(ABC):
    """Owns a thread in which time goes on while nobody pauses it; in between it does what people ask for.

    Requests are made between two steps by the thread of :meth:`serve`; services wait for their answer.

    Args:
        hub: of the clients.
        requests: of the session that owns the thread; by default it is this one.

    Attributes:
        requests: what people wait for.
        mode: what it does now.
        doing: in words, while it is busy.
        pace: simulated seconds a wall second at most; None: as fast as it can.
        reports: what it says about itself; a session sets it when it is made.
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
        """What it does now, in one word."""
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
        """Go on and answer until :meth:`close` or Ctrl-C; in the thread that owns the session."""
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
        """Let the thread of the session make a call between two steps; return its result or raise its error.

        Args:
            call: what to do.
            doing: what the page says meanwhile, for what takes long.
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

    # -- going on

    def play(self) -> None:
        """Go on to the end."""
        self._play_to(self.end_ns)

    def run_to(self, t_s: float) -> None:
        """Go on to a time."""
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
        """Go back to the beginning, as far as ``what`` says."""

    @abstractmethod
    def set_pace(self, factor: float | None) -> None:
        """Set how many simulated seconds a wall second may hold; None: as fast as it can."""

    def _play_to(self, until_ns: int) -> None:
        self._require_going()
        if until_ns <= self.now_ns:
            raise LifecycleError(f"the run is at {seconds(self.now_ns):g} s already")
        self._go_from_here()
        self._until_ns, self.mode = until_ns, Mode.RUNNING
        self.reports.progress()

    def _require_going(self) -> None:
        if self.mode in (Mode.FINISHED, Mode.FAILED):
            raise LifecycleError("the run is over: step back or reset")

    def _step_at(self, t_s: float) -> int:
        """Return the time of the step at or after a time."""
        return -(-from_seconds(t_s) // self.timestep_ns) * self.timestep_ns

    def _look_whether_there(self) -> None:
        """Stop if the time is the one to go to."""
        if self.mode is Mode.RUNNING and self.now_ns >= min(self._until_ns, self.end_ns):
            self.mode = Mode.FINISHED if self.now_ns >= self.end_ns else Mode.PAUSED
            self.reports.progress()

    # -- the thread

    @property
    def _wanted(self) -> bool:
        """Whether somebody waits for an answer, or for the end."""
        return self.requests.wanted

    def _rest(self, wall_s: float) -> None:
        """Wait, at most until somebody asks for something."""
        self.requests.wait(wall_s)

    @abstractmethod
    def _go_from_here(self) -> None:
        """Prepare to go on from the time that it is."""

    @abstractmethod
    def _advance(self) -> None:
        """Go on, until somebody asks for something at most."""

    @abstractmethod
    def _idle(self) -> None:
        """Do what is due while nothing goes on."""

    @abstractmethod
    def _end(self) -> None:
        """End everything."""
