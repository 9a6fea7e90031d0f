"""A run that people watch and steer."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nrp_cockpit.hearing.hearing import Hearing
from nrp_cockpit.session.bodies import Bodies
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.live_reports import LiveReports
from nrp_cockpit.session.past import Past
from nrp_cockpit.session.session import Mode, Session
from nrp_cockpit.wire.hub import Hub
from nrp_core.cle.pacing import AsFastAsPossible, Paced
from nrp_core.clock import seconds
from nrp_core.errors import NrpError
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder


class LiveSession(Session):
    """Owns the thread of a run: it steps while nobody pauses it.

    Args:
        run: an open run, between two steps.
        hub: of the clients.
    """

    def __init__(self, run: Run, hub: Hub) -> None:
        super().__init__(hub)
        self.run = run
        self._going_since: float | None = None
        self._recording: RecordingFolder | None = None
        self.recording_path: Path | None = None
        can_save = run.brain.capabilities.snapshot and run.world.capabilities.snapshot
        self.hearing = Hearing(run, hub)
        self.past = Past(run, can_save=can_save)
        self.functions = Functions(run)
        self.bodies = Bodies(run)
        self.reports = LiveReports(self)
        run.loop.hooks.after_step.append(self._after_step)
        run.loop.pacing = Paced()

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
    def going_s(self) -> float:
        """Wall time since the run began to step, s; its result counts it when it stops."""
        return 0.0 if self._going_since is None else time.monotonic() - self._going_since

    # -- running

    def step(self, n: int = 1) -> None:
        """Take some steps."""
        self._require_going()
        self._go_from_here()
        self.mode = Mode.PAUSED
        until_ns = self.now_ns + n * self.timestep_ns
        self._guarded(lambda: self._run_through(until_ns))
        self.reports.all()

    def _go_from_here(self) -> None:
        """Forget what came later: the run may go another way."""
        self.past.forget_after(self.now_ns)

    def _advance(self) -> None:
        """Run until the end, or until somebody asks for something."""
        self._guarded(lambda: self.run.run_until(seconds(self._until_ns)))
        self._look_whether_there()

    def _idle(self) -> None:
        self.hearing.take()
        self.reports.idle()

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
        if self._wanted or self.mode is Mode.PAUSED:
            loop.stop()

    # -- time

    def set_pace(self, factor: float | None) -> None:
        """Set how many simulated seconds a wall second may hold; None: as fast as it can."""
        self.run.loop.pacing = AsFastAsPossible() if factor is None else Paced(factor)
        self.pace = factor
        self.reports.status()

    def seek(self, t_s: float) -> None:
        """Go to a time: back by a snapshot and forward from there, or forward."""
        until_ns = min(self._step_at(max(t_s, 0.0)), self.end_ns)
        if until_ns > self.now_ns:
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
            while self.now_ns < until_ns and not self._closing:
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
        if self.now_ns >= self.end_ns:
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

    def _end(self) -> None:
        over = self.mode is Mode.FINISHED
        self._end_recording("finished" if over else "interrupted")
        self._answer()
        self.hearing.close()
        self.past.close()
        self.functions.close()
