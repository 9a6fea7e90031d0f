"""A run that people watch and steer."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from enum import StrEnum
from pathlib import Path
from typing import Any

from nrp_cockpit.hearing.hearing import Hearing
from nrp_cockpit.session.bodies import Bodies
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.past import Past
from nrp_cockpit.session.reports import Reports
from nrp_cockpit.wire.hub import Hub
from nrp_core.cle.pacing import AsFastAsPossible, Paced
from nrp_core.clock import from_seconds, seconds
from nrp_core.errors import LifecycleError, NrpError
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder


class Mode(StrEnum):
    """What a session does."""

    PAUSED = "paused"
    RUNNING = "running"
    FINISHED = "finished"
    FAILED = "failed"
    BUSY = "busy"


class LiveSession:
    """Owns the thread of a run: it steps while nobody pauses it, and does in between what people ask for.

    Requests are made between two steps by the thread of :meth:`serve`; services wait for their answer.

    Args:
        run: an open run, between two steps.
        hub: of the clients.

    Attributes:
        mode: what it does now.
        doing: in words, while it is busy.
        pace: simulated seconds a wall second at most; None: as fast as it can.
    """

    def __init__(self, run: Run, hub: Hub) -> None:
        self.run, self.hub = run, hub
        self.mode, self.doing = Mode.PAUSED, ""
        self.pace: float | None = 1.0
        self._until_ns = 0
        self._closing = False
        self._going_since: float | None = None
        self._requests: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._asked = threading.Condition()
        self._recording: RecordingFolder | None = None
        self.recording_path: Path | None = None
        can_save = run.brain.capabilities.snapshot and run.world.capabilities.snapshot
        self.hearing = Hearing(run, hub)
        self.past = Past(run, can_save=can_save)
        self.functions = Functions(run)
        self.bodies = Bodies(run)
        self.reports = Reports(self)
        run.loop.hooks.after_step.append(self._after_step)
        self.run.loop.pacing = Paced(self.pace)

    def serve(self) -> None:
        """Step and answer until :meth:`close`; in the thread that owns the run."""
        self.reports.all()
        while not self._closing:
            self._answer()
            if self._closing:
                break
            if self.mode is Mode.RUNNING:
                self._advance()
            else:
                self.hearing.take()
                self.reports.idle()
                with self._asked:
                    self._asked.wait_for(lambda: self._requests or self._closing, 0.1)
        self._end()

    def close(self) -> None:
        """End :meth:`serve` after the current step; any thread may call this."""
        with self._asked:
            self._closing = True
            self._asked.notify_all()
        self.run.loop.stop()

    def ask(self, call: Callable[[], Any], doing: str = "") -> Any:
        """Let the thread of the run make a call between two steps; return its result or raise its error.

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

        future: Future[Any] = Future()
        with self._asked:
            if self._closing:
                raise LifecycleError("the run is being closed")
            self._requests.append((busy if doing else call, future))
            self._asked.notify_all()
        return future.result()

    @property
    def state(self) -> str:
        """What it does now, in one word."""
        return str(self.mode)

    @property
    def going_s(self) -> float:
        """Wall time since the run began to step, s; its result counts it when it stops."""
        return 0.0 if self._going_since is None else time.monotonic() - self._going_since

    # -- running

    def play(self) -> None:
        """Run to the end of the experiment."""
        self._play_to(from_seconds(seconds(self.run.experiment.duration)))

    def run_to(self, t_s: float) -> None:
        """Run to a time."""
        self._play_to(self._step_at(t_s))

    def pause(self) -> None:
        """Stop after the current step."""
        if self.mode is Mode.RUNNING:
            self.mode = Mode.PAUSED
        self.reports.all()

    def step(self, n: int = 1) -> None:
        """Take some steps."""
        self._require_going()
        self.past.forget_after(self.run.loop.now_ns)
        self.mode = Mode.PAUSED
        until_ns = self.run.loop.now_ns + n * self.run.experiment.timestep
        self._guarded(lambda: self._run_through(until_ns))
        self.reports.all()

    def _play_to(self, until_ns: int) -> None:
        self._require_going()
        now_ns = self.run.loop.now_ns
        if until_ns <= now_ns:
            raise LifecycleError(f"the run is at {seconds(now_ns):g} s already")
        self.past.forget_after(now_ns)
        self._until_ns, self.mode = until_ns, Mode.RUNNING
        self.reports.all()

    def _require_going(self) -> None:
        if self.mode in (Mode.FINISHED, Mode.FAILED):
            raise LifecycleError("the run is over: step back or reset")

    def _step_at(self, t_s: float) -> int:
        """Return the time of the step at or after a time."""
        step_ns = self.run.experiment.timestep
        return -(-from_seconds(t_s) // step_ns) * step_ns

    def _advance(self) -> None:
        """Run until the end, or until somebody asks for something."""
        self._guarded(lambda: self.run.run_until(seconds(self._until_ns)))
        if self.mode is Mode.RUNNING and self.run.loop.now_ns >= self._until_ns:
            at_end = self.run.loop.now_ns >= self.run.experiment.duration
            self.mode = Mode.FINISHED if at_end else Mode.PAUSED
            self.reports.all()

    def _guarded(self, go: Callable[[], Any]) -> None:
        self._going_since = time.monotonic()
        try:
            go()
        except KeyboardInterrupt:
            self._closing = True
        except NrpError as error:
            self.mode = Mode.FAILED
            self.reports.log("error", str(error))
            self.reports.all()
        finally:
            self._going_since = None

    def _after_step(self, loop: Any) -> None:
        self.hearing.take()
        self.functions.after_step(loop)
        self.past.after_step()
        self.reports.after_step()
        if self._requests or self._closing or self.mode is Mode.PAUSED:
            loop.stop()

    # -- time

    def set_pace(self, factor: float | None) -> None:
        """Set how many simulated seconds a wall second may hold; None: as fast as it can."""
        self.run.loop.pacing = AsFastAsPossible() if factor is None else Paced(factor)
        self.pace = factor
        self.reports.status()

    def step_back(self) -> None:
        """Return to the step before this one."""
        self.seek(seconds(self.run.loop.now_ns - self.run.experiment.timestep))

    def seek(self, t_s: float) -> None:
        """Go to a time: back by a snapshot and forward from there, or forward."""
        until_ns = min(self._step_at(max(t_s, 0.0)), self.run.experiment.duration)
        if until_ns > self.run.loop.now_ns:
            self._guarded(lambda: self._run_through(until_ns))
        else:
            self._unpaced(lambda: self.past.return_to(until_ns))
        self._jumped(Mode.PAUSED)

    def restore(self, name: str) -> None:
        """Return to a snapshot."""
        self.past.restore(self.past.named(name))
        self._jumped(Mode.PAUSED)

    def snapshot(self) -> dict[str, Any]:
        """Take a snapshot and return its name and time."""
        moment = self.past.take()
        self.reports.timeline()
        return {"id": moment.id, "t_s": seconds(moment.t_ns)}

    def reset(self, what: str = "all") -> None:
        """Reset everything to time 0, or the robots or the world while time goes on."""
        if what == "all":
            self.run.loop.reset()
            self.past.begin_again()
            self._jumped(Mode.PAUSED)
            return
        self.bodies.reset(what)
        self.hearing.take()

    def _run_through(self, until_ns: int) -> None:
        """Run to a time as fast as it can, whoever asks for something meanwhile."""

        def steps() -> None:
            while self.run.loop.now_ns < until_ns and not self._closing:
                self.run.step()

        self._unpaced(steps)

    def _unpaced(self, go: Callable[[], Any]) -> None:
        pace = self.pace
        self.run.loop.pacing = AsFastAsPossible()
        try:
            go()
        finally:
            self.set_pace(pace)

    def _jumped(self, mode: Mode) -> None:
        """Tell everybody that the time is another one."""
        if self.mode is not Mode.FAILED or self.run.error is None:
            self.mode = mode
        if self.run.loop.now_ns >= self.run.experiment.duration:
            self.mode = Mode.FINISHED
        self.functions.begin_again()
        self.hearing.begin_again()
        self.hearing.take()
        self.reports.all()

    # -- recording

    def record(self, folder: str | None) -> dict[str, Any]:
        """Begin to record into a new folder, or end the recording (None)."""
        if folder is None:
            self._end_recording("interrupted")
        elif self._recording is None:
            path = Path(folder or f"recordings/{self.run.experiment.name}-{time.strftime('%Y%m%d-%H%M%S')}")
            self._recording = RecordingFolder(self.run, path.absolute())
            self.recording_path = path.absolute()
        self.reports.status()
        return {"path": None if self.recording_path is None else str(self.recording_path)}

    def _end_recording(self, state: str) -> None:
        recording, self._recording, self.recording_path = self._recording, None, None
        if recording is not None:
            recording.close(state)

    # -- the thread

    def _answer(self) -> None:
        while self._requests:
            call, future = self._requests.popleft()
            try:
                future.set_result(call())
            except BaseException as error:  # noqa: BLE001  it belongs to whoever asked
                future.set_exception(error)

    def _end(self) -> None:
        over = self.mode is Mode.FINISHED
        self._end_recording("finished" if over else "interrupted")
        self._answer()
        self.hearing.close()
        self.past.close()
        self.functions.close()
