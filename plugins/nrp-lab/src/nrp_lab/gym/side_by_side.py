"""Steps of many loops at once, for copies of an experiment in one process."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from nrp_core.brain import Closing
from nrp_core.cle.loop import ClosedLoop
from nrp_core.utilities import time_limit


class SideBySide(Closing):
    """Steps independent loops together; each takes the step that it would take alone.

    Brains and worlds of all loops advance on threads. Transfer functions and hooks run on the calling thread,
    loop by loop, because code of users may share values. The pace of a loop is ignored, and calls
    that other threads make on a loop are not held back until the end of a step.

    Args:
        threads: number of threads; 1: the calling one.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads, "copies") if threads > 1 else None

    def step(self, loops: Sequence[ClosedLoop]) -> dict[int, Exception]:
        """Take one step of each loop; one that fails does not stop the others.

        Returns:
            The errors of the loops that failed, by their numbers.
        """
        if not loops:
            return {}
        limit = loops[0].time_limit
        for loop in loops:
            loop.time_limit = limit  # a limit of its own for each would be a thread for each
        failed: dict[int, Exception] = {}
        with time_limit.DeferredInterrupt(), limit.watching():
            if self._pool is None:  # a loop at a time, while the data of its sides are in the fastest caches
                self._each(loops, _step, failed)
            else:
                self._each(loops, ClosedLoop.begin_step, failed)
                self._each(loops, ClosedLoop.advance_in_turn, failed, self._pool)
                self._each(loops, _end, failed)
        return dict(sorted(failed.items()))

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _each(
        self,
        loops: Sequence[ClosedLoop],
        part: Callable[[ClosedLoop], None],
        failed: dict[int, Exception],
        pool: ThreadPoolExecutor | None = None,
    ) -> None:
        """Call a part of the step for each loop that has not failed, on the threads of a pool if given."""

        def work(share: range) -> None:
            for number in share:
                if number not in failed:
                    try:
                        part(loops[number])
                    except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                        loops[number].is_stepping = False
                        failed[number] = error

        shares = [range(first, len(loops), self.threads) for first in range(self.threads)]
        list(pool.map(work, shares) if pool is not None else map(work, shares))


def _step(loop: ClosedLoop) -> None:
    loop.begin_step()
    loop.advance_in_turn()
    _end(loop)


def _end(loop: ClosedLoop) -> None:
    failure = loop.end_step()
    if failure is not None:
        raise failure.to_error() from failure.error
