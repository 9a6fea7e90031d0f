"""A live run that clients watch and control."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nrp_cockpit.session.bodies import Bodies
from nrp_cockpit.session.companion import Companion
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.live_reports import LiveReports
from nrp_cockpit.session.past import ALONE_NS, WATCHED_NS, Past
from nrp_cockpit.session.requests import Requests
from nrp_cockpit.session.session import Mode, Session
from nrp_cockpit.streaming.live import LiveStream
from nrp_cockpit.wire.hub import Hub
from nrp_core.cle.pacing import AsFastAsPossible, Paced
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, LifecycleError, NrpError
from nrp_core.experiment import Run
from nrp_core.recording import FilesRead
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.utilities import work

_MOMENT_S = 0.05
"""Below this wall time it only sleeps: waiting for requests as well would cost more."""


class LiveSession(Session):
    """Owns the thread of a run, which steps unless it is paused.

    Args:
        run: an open run, between two steps.
        hub: of the clients.
        requests: those of the session that owns the thread, by default this one.
        functions: the transfer functions of the run; by default those on disk.
        files: the files that the run was read from, which its recordings keep.

    Attributes:
        beside: the second run that follows it, if any.
        recording_path: the folder of the current recording, if any.
        recorded_path: the folder of the last recording that has ended, if any.
    """

    def __init__(
        self,
        run: Run,
        hub: Hub,
        requests: Requests | None = None,
        functions: Functions | None = None,
        files: FilesRead | None = None,
    ) -> None:
        super().__init__(hub, requests)
        self.beside: Companion | None = None
        self._jumping = self._is_halted = False
        self._going_since: float | None = None
        self._gone_s = 0.0
        self._files = files
        self._recording: RecordingFolder | None = None
        self.recording_path: Path | None = None
        self.recorded_path: Path | None = None
        self._attend(run, functions or Functions(run))

    def _attend(self, run: Run, functions: Functions) -> None:
        self.run, self.functions = run, functions
        can_save = run.brain.capabilities.snapshot and run.world.capabilities.snapshot
        self.stream = LiveStream(run, self.hub)
        self.past = Past(run, can_save=can_save, halted=lambda: self._is_halted)
        self.bodies = Bodies(run)
        self.reports = LiveReports(self)
        run.loop.hooks.after_step.append(self._after_step)
        run.loop.pacing = Paced(sleep=self._sleep)

    def exchange(self, run: Run, functions: Functions) -> None:
        """Close the run and continue with another one from its beginning.

        Args:
            run: an open run.
            functions: its transfer functions.
        """
        self._end_recording_of_the_past()
        self._end_observation()
        self.run.close()
        before = self.stream.topics
        self._attend(run, functions)
        self.hub.withdraw(before - self.stream.topics)
        self.set_pace(self.pace)
        self._gone_s = 0.0
        self._jumped()

    @property
    def now_ns(self) -> int:
        return self.run.loop.now_ns

    @property
    def end_ns(self) -> int:
        return self.run.experiment.duration

    @property
    def timestep_ns(self) -> int:
        return self.run.experiment.timestep

    def close(self) -> None:
        super().close()
        self.run.loop.stop()

    @property
    def wall_s(self) -> float:
        """Wall time in which the run stepped since its beginning, s."""
        since = self._going_since
        return self._gone_s + (0.0 if since is None else time.monotonic() - since)

    # -- running

    def step(self, n: int = 1) -> None:
        """Take some steps."""
        if n < 1:
            raise ExperimentError(f"the number of steps must be 1 or more, not {n}")
        self._require_going()
        self._go_from_here()
        self._is_halted = False
        self.mode = Mode.PAUSED  # "running" would turn Play into Pause under the pointer for a moment
        until_ns = min(self.now_ns + n * self.timestep_ns, self.end_ns)
        self._guarded(lambda: self._unpaced(lambda: self._run_through(until_ns)))
        if self.mode is Mode.PAUSED:
            self._stop_here()

    def _go_from_here(self) -> None:
        """Forget the later past: the run may differ this time."""
        self.past.forget_after(self.now_ns)
        if self.beside is not None:
            self.beside.go_from_here()

    def _advance(self) -> None:
        """Run until the end or until a request arrives."""
        if self.now_ns == 0:
            self._take_first_step()
        else:
            self._guarded(lambda: self.run.run_until(seconds(self._until_ns)))
        self._look_whether_there()

    def _take_first_step(self) -> None:
        """Take the first step, and say so meanwhile: a brain that is compiled for it can take a minute."""
        self.doing = "Preparing the first step"
        self.reports.status()
        self._guarded(self.run.step)
        self.doing = ""
        self.reports.status()

    def _idle(self) -> None:
        self.stream.take()
        self.reports.idle()
        if self.beside is not None:
            self.beside.idle()

    def _guarded(self, go: Callable[[], Any]) -> None:
        self.stream.take()  # whoever subscribed just before gets the first step, too
        self._going_since = time.monotonic()
        try:
            go()
        except NrpError as error:
            self.mode = Mode.FAILED
            self.reports.log("error", self.functions.drafts.in_place(str(error)))
            self.reports.progress()
        finally:
            self._gone_s, self._going_since = self.wall_s, None
            self.stream.take_poses_again()  # those of the last step, which are not sent with every step

    def _after_step(self, loop: Any) -> None:
        if self.beside is not None and not self._jumping:
            began_ns = work.now_ns()
            self.beside.follow()  # before the report, which compares equal steps
            loop.account.total_ns -= work.now_ns() - began_ns  # the second run is not part of this one
        if self.hub.listeners:
            self._show_step()
        else:
            self.stream.take()  # whoever comes late sees what happened
            if loop.brain.now_ns >= self.past.due_ns:
                self.past.after_step(ALONE_NS)
        if self.requests.wanted:
            loop.stop()

    def _show_step(self) -> None:
        """Send the step to the clients."""
        self.functions.costs.watch()
        with self.hub.together():
            self.stream.take()
            self.reports.after_step()
        self.past.after_step(WATCHED_NS)

    # -- time

    def set_pace(self, factor: float | None) -> None:
        """Limit the simulated seconds per wall second; None: as fast as possible."""
        self.run.loop.pacing = AsFastAsPossible() if factor is None else Paced(factor, sleep=self._sleep)
        self.pace = factor
        self.reports.status()

    def _sleep(self, wall_s: float) -> None:
        """Wait for the next step, and stop waiting when a request arrives."""
        if wall_s < _MOMENT_S:
            time.sleep(wall_s)
            return
        self._rest(wall_s)
        if self._wanted:
            self.run.loop.stop()

    def seek(self, t_s: float) -> None:
        """Go to a time: back by a snapshot and forward from there, or forward."""
        until_ns = min(self._step_at(max(t_s, 0.0)), self.end_ns)
        live_again = self.past.way_to(until_ns, self.stream.longest_period_ns)
        if until_ns < self.now_ns:
            self._end_recording_of_the_past()

        def go() -> None:
            live_again()
            self._run_through(until_ns)

        self._is_halted = False
        self._jumping = True  # the second run follows in one go
        try:
            self._guarded(lambda: self._unpaced(go))
        finally:
            self._jumping = False
        self._jumped()

    def restore(self, name: str) -> None:
        """Return to a snapshot."""
        moment = self.past.named(name)
        is_elsewhere = not moment.was
        self._end_recording_of_the_past()
        self.past.restore(moment)
        self._jumped(is_elsewhere=is_elsewhere)

    def snapshot(self) -> dict[str, Any]:
        """Take a snapshot and return its name and time."""
        moment = self.past.take()
        self.reports.timeline()
        return {"id": moment.id, "t_s": seconds(moment.t_ns)}

    def forget(self, name: str) -> None:
        """Forget a snapshot."""
        self.past.forget(name)
        self.reports.timeline()

    def halt(self) -> None:
        """Stop on the way to another time after the current step; any thread may call this."""
        self._is_halted = True

    def reset(self, what: str = "all") -> None:
        """Reset everything to time 0, or one part without changing the time."""
        if what != "brain":
            self.bodies.forget()
        if what != "all":
            self.run.reset(what)
            self.steered(f"{what} reset")
            return
        self._end_recording_of_the_past()
        self.past.keep_end()
        self.run.reset()
        self.past.reset()
        self._gone_s = 0.0
        self._jumped()

    def steered(self, name: str) -> None:
        """Note a change of the run that repeating it would miss; see :meth:`.Past.mark`."""
        self.past.mark(name)
        self.stream.offer_all()
        self.stream.take_poses_again()
        self.stream.take()
        self.reports.all()

    def _run_through(self, until_ns: int) -> None:
        """Run to a time without a pause for requests."""
        while self.now_ns < until_ns and not (self.requests.is_closed or self._is_halted):
            self.run.step()

    def _unpaced(self, go: Callable[[], Any]) -> None:
        """Run as fast as possible."""
        pacing, self.run.loop.pacing = self.run.loop.pacing, AsFastAsPossible()
        try:
            go()
        finally:
            self.run.loop.pacing = pacing

    def _unpaced_always(self) -> None:
        """Run as fast as possible, independent of the pace."""
        self.run.loop.pacing = AsFastAsPossible()

    def _jumped(self, *, is_elsewhere: bool = False) -> None:
        """Report that the time has jumped.

        Args:
            is_elsewhere: whether it went to an abandoned past.
        """
        if self.run.error is None:
            self.mode = Mode.FINISHED if self.now_ns >= self.end_ns else Mode.PAUSED
        self.functions.costs.reset()
        self.stream.reset(is_elsewhere=is_elsewhere)
        self.stream.take()
        if self.beside is not None:
            self.beside.go_along()
        self.reports.all()

    # -- recording

    def record(self, folder: str | None) -> dict[str, Any]:
        """Begin to record into a new folder, or end the recording (None)."""
        if folder is None:
            self._end_recording("interrupted")
        elif self._recording is not None:
            raise LifecycleError(f"the run is already being recorded to {self.recording_path}")
        else:
            path = Path(folder or f"recordings/{self.run.experiment.name}-{time.strftime('%Y%m%d-%H%M%S')}")
            self._recording = RecordingFolder(self.run, path.absolute(), files=self._files)
            self.recording_path = path.absolute()
        self.reports.status()
        return {"path": None if self.recording_path is None else str(self.recording_path)}

    def _end_recording(self, state: str) -> None:
        recording, self._recording = self._recording, None
        path, self.recording_path = self.recording_path, None
        if recording is not None:
            recording.close(state)
            self.recorded_path = path

    def _end_recording_of_the_past(self) -> None:
        """End the recording, because its time cannot go back."""
        if self._recording is not None:
            self.reports.log(
                "warning", f"the recording ended because the run went back in time: {self.recording_path}"
            )
            self._end_recording("interrupted")

    def _end(self) -> None:
        if self.beside is not None:
            beside, self.beside = self.beside, None
            beside.end()
        try:
            self._end_recording("finished" if self.mode is Mode.FINISHED else "interrupted")
        finally:
            self._end_observation()

    def _end_observation(self) -> None:
        self.run.loop.hooks.after_step.remove(self._after_step)
        self.stream.close()
        self.past.close()
        self.functions.close()
