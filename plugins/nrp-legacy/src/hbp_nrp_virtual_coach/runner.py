"""A run in a thread of its own, which opens it, runs it, and makes the calls of all other threads."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection
from concurrent.futures import Future
from contextlib import suppress
from typing import Any, TypeVar

from hbp_nrp_virtual_coach.settings import log
from nrp_core.checks.warnings import announcement
from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import LifecycleError
from nrp_core.experiment import Experiment, Run
from nrp_core.findings import Weight
from nrp_core.recording import FilesRead
from nrp_core.running import open_checked_run

T = TypeVar("T")

PAUSED, STARTED, STOPPED, HALTED = "paused", "started", "stopped", "halted"
_REPORT_S, _POLL_S = 1.0, 0.001


class Runner:
    """Runs an experiment in the background; returns when it is open and paused.

    Args:
        read: reads the experiment.
        on_status: called with the status at every whole second of simulated time, when the state has changed,
            and at least every second; in the thread of the run, between two steps.
        on_end: called with the run at its end, before it is closed.
        on_open: called with the run when it is open, in its thread.

    Attributes:
        state: ``paused``, ``started``, ``stopped``, or ``halted`` by an error.
        error: the error that halted it.
        files: the files that it was read from, which its recordings keep.

    Raises:
        NrpError: the experiment cannot be opened.
    """

    def __init__(
        self,
        read: Callable[[], Experiment],
        on_status: Callable[[dict[str, Any]], None],
        on_end: Callable[[Run], None],
        on_open: Callable[[Run], None],
    ) -> None:
        self._read, self._on_status, self._on_end, self._on_open = read, on_status, on_end, on_open
        self.state, self.error = PAUSED, None
        self._is_due, self._is_closed, self._is_silent, self._wall_s = False, False, False, 0.0
        self._failed = 0
        self._opened: Future[Run] = Future()
        self._thread = threading.Thread(target=self._main, daemon=True, name="virtual coach")
        self._thread.start()
        self._opened.result()

    error: Exception | None
    files: FilesRead
    _run: Run

    # -- for all threads

    def call(self, action: Callable[[Run], T]) -> T:
        """Call a function with the run, in the thread of the run and between two steps; return its result.

        Raises:
            LifecycleError: the simulation has ended.
        """

        def make() -> T:
            if self._is_closed:
                raise LifecycleError("the simulation is stopped; launch the experiment again")
            return action(self._run)

        return self._run.loop.between_steps(make)

    def poll(self) -> str:
        """Return the state, to another thread after a moment, so that polling leaves the run time.

        A run that has stopped is released by then: scripts read its files as soon as they learn of it.
        """
        state = self.state
        if state == STOPPED:
            self.wait()
        elif threading.current_thread() is not self._thread:
            time.sleep(_POLL_S)
        return state

    def start(self) -> None:
        """Let the run go on.

        Raises:
            LifecycleError: the simulation has ended, or an error has halted it.
        """

        def change(run: Run) -> None:
            if self.state == STOPPED:
                raise LifecycleError("the simulation is stopped; launch the experiment again")
            if self.state == HALTED:
                raise LifecycleError(f"the simulation was halted by an error: {self.error}") from self.error
            self._set(run, STARTED)

        self.call(change)

    def pause(self) -> None:
        """Pause the run; do nothing if it is paused."""
        self.call(lambda run: self._set(run, PAUSED) if self.state == STARTED else None)

    def reset(self, action: Callable[[Run], None]) -> None:
        """Pause the run, and make a change after which it waits, whatever halted it before."""

        def change(run: Run) -> None:
            action(run)
            self.error = None
            self._failed = len(run.loop.failures)
            self._set(run, PAUSED)
            self._is_due = True
            self._wall_s = self._wall_s if run.loop.now_ns else 0.0

        self.pause()
        self.call(change)

    def stop(self, *, silently: bool = False) -> None:
        """End the run and release it; do nothing if it has ended.

        Args:
            silently: whether its end is not reported, because another run takes its place.
        """
        self._is_silent = self._is_silent or silently
        if self.state != STOPPED:
            with suppress(LifecycleError):  # it may end just now
                self.call(lambda run: self._set(run, STOPPED))
        self.wait()

    def wait(self) -> None:
        """Wait until a run that was stopped is released, unless this is its thread."""
        if threading.current_thread() is not self._thread:
            self._thread.join()

    # -- in the thread of the run

    def end(self) -> None:
        """End the run after its current step."""
        self._set(self._run, STOPPED)

    def _main(self) -> None:
        try:
            with FilesRead() as self.files, open_checked_run(self._read()) as run:
                run.on_step(self._look_at_clock)
                with run.loop.serving_calls():
                    self._run, self._reported_at = run, time.monotonic()
                    _log_problems(run)
                    known = {problem.message for problem in run.problems}
                    self._on_open(run)
                    self._opened.set_result(run)
                    self._attend(run)
                    self._on_end(run)
                    _log_new(run, known)
                    if not self._is_silent:
                        self._report(run)
                    self._is_closed = True
        except BaseException as error:  # noqa: BLE001 - it belongs to whoever launched it
            if self._opened.done():
                log.exception("the simulation ended with an error")
            else:
                self._opened.set_exception(error)
        self.state, self._is_closed = STOPPED, True

    def _attend(self, run: Run) -> None:
        while self.state != STOPPED:
            if self.state == STARTED:
                self._advance(run)
            elif not self._is_due:
                run.loop.attend(_REPORT_S)
            if self.state != STOPPED and self._is_report_due():
                self._report(run)

    def _is_report_due(self) -> bool:
        return self._is_due or time.monotonic() - self._reported_at >= _REPORT_S

    def _advance(self, run: Run) -> None:
        """Run to the next whole second, if nothing intervenes."""
        period_ns, now_ns = run.experiment.timestep, run.loop.now_ns
        second_ns = (now_ns // NS_PER_S + 1) * NS_PER_S
        step_after_ns = -(-second_ns // period_ns) * period_ns
        end_ns = min(step_after_ns, run.experiment.duration)
        began = time.monotonic()
        try:
            run.run_until(seconds(end_ns))
        except Exception as error:  # noqa: BLE001 - the run halts, and whoever calls learns why
            log.error("the simulation is halted: %s", error)
            self.error = error
            self._set(run, HALTED)
        self._wall_s += time.monotonic() - began
        self._log_failures(run)
        self._is_due = self._is_due or run.loop.now_ns == end_ns
        if run.loop.now_ns >= run.experiment.duration:
            self._set(run, STOPPED)

    def _log_failures(self, run: Run) -> None:
        """Log the functions that have failed since the last call; a reset forgets them."""
        failures = run.loop.failures
        for failure in failures[self._failed :]:
            log.error("transfer function '%s' is set aside: %s", failure.function, failure)
        self._failed = len(failures)

    def _look_at_clock(self, run: Run) -> None:
        if self._is_report_due():
            run.loop.stop()

    def _set(self, run: Run, state: str) -> None:
        self._is_due = self._is_due or state != self.state
        self.state = state
        run.loop.stop()

    def _report(self, run: Run) -> None:
        self._is_due, self._reported_at = False, time.monotonic()
        self._on_status({
            "simulationTime": run.now_s,
            "realTime": self._wall_s,
            "state": self.state,
            "timeout": seconds(run.experiment.duration) - run.now_s,
        })  # fmt: skip


def _log_new(run: Run, known: Collection[str]) -> None:
    """Log the new problems of a run that were not logged when they happened."""
    for problem in run.problems:
        if problem.weight is Weight.ALTERED and problem.message not in known:
            log.warning("%s", problem)


def _log_problems(run: Run) -> None:
    """Log the missing parts of a run at its beginning, and once the warnings of the checks."""
    missing = [problem for problem in run.problems if problem.weight is Weight.INCOMPLETE]
    for problem in missing:
        log.warning("the simulation is not complete: %s", problem)
    if text := announcement(run.experiment.name, [one for one in run.problems if one not in missing]):
        log.warning("%s", text)
