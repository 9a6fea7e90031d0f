"""Deaths of workers: a run is their likely cause only if it had begun each time."""

from __future__ import annotations

from dataclasses import replace

from nrp_core.errors import BackendLoadError
from nrp_lab.sweep.record import Record, Task

ATTEMPTS = 5
"""Number of attempts of a run whose worker dies in it; after that the run itself is the likely cause."""


class Deaths:
    """Decides how to go on when workers have died.

    Args:
        most_in_vain: number of deaths before a run begins that end the sweep, if no worker lives in between.
    """

    def __init__(self, most_in_vain: int) -> None:
        self._most_in_vain, self._in_vain = most_in_vain, 0

    def workers_live(self) -> None:
        """Note that a run has ended or begun, so that workers are able to start."""
        self._in_vain = 0

    def in_run(self, task: Task, cause: str, times: int = 1) -> Task | Record:
        """Return the next attempt of a run that had begun, or its record after the last one.

        Args:
            task: the attempt, or the first of several.
            cause: how the worker ended.
            times: number of workers that died in this run.
        """
        self.workers_live()
        last = replace(task, attempt=task.attempt + times - 1)
        return last.again() if last.attempt < ATTEMPTS else Record.died(last, cause)

    def in_vain(self, cause: str) -> None:
        """Note a death before a run began; no run is to blame.

        Raises:
            BackendLoadError: workers never live until a run begins.
        """
        self._in_vain += 1
        if self._in_vain >= self._most_in_vain:
            raise BackendLoadError(f"workers die before a run begins ({cause}); finished runs are kept")
