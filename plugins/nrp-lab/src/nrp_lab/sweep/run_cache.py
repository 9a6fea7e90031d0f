"""The run that a worker keeps open, because the next task may differ only in the seed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nrp_core.errors import CapabilityError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_lab.sweep.record import Task

_SEED = "seed="


class KeptRun:
    """At most one open run, and the task that it was opened for."""

    def __init__(self) -> None:
        self._run: Run | None = None
        self._of: tuple[str, tuple[str, ...]] | None = None

    @contextmanager
    def opened(self, task: Task, *, keep: bool) -> Iterator[Run]:
        """Return a run of a task at time 0: a new one, or the open one after a reset.

        Args:
            task: the task.
            keep: whether the run may stay open afterwards; a run that ended early is always closed.
        """
        others = tuple(text for text in task.overrides if not text.startswith(_SEED))
        run = self._started_over(task, (task.experiment, others)) if keep else None
        if run is None:
            self.close()
            run = Run(load_experiment(task.experiment, task.overrides))
        try:
            yield run
        except BaseException:
            run.close()
            raise
        if keep and run.error is None and not run.loop.failures:
            self._run, self._of = run, (task.experiment, others)
        else:
            run.close()

    def close(self) -> None:
        """Release its engines."""
        run, self._run = self._run, None
        if run is not None:
            run.close()

    def _started_over(self, task: Task, of: tuple[str, tuple[str, ...]]) -> Run | None:
        """Return the open run at time 0 if it has the same settings; the caller then owns it."""
        seeds = [int(text.removeprefix(_SEED)) for text in task.overrides if text.startswith(_SEED)]
        if self._run is None or self._of != of or len(seeds) != 1:
            return None
        try:
            self._run.start_over(seeds[0])
        except CapabilityError:
            return None
        run, self._run = self._run, None
        return run


KEPT = KeptRun()
"""The run that this process keeps open."""
