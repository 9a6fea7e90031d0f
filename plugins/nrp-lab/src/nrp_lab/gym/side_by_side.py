"""Steps of many loops at once, for copies of an experiment in one process."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, TypeAlias

from nrp_core.brain import Closing
from nrp_core.cle.loop import ClosedLoop, EndOfStep, VectorizedCall, call_for_copies
from nrp_core.utilities import time_limit

Waiting: TypeAlias = tuple[EndOfStep, VectorizedCall]
"""The end of a step, and the call of a vectorised function that it waits for."""


class SideBySide(Closing):
    """Steps independent loops together; each takes the step that it would take alone.

    Brains and worlds of all loops advance on threads. Transfer functions and hooks run on the calling thread,
    loop by loop, because users' code may share values; vectorised functions are called once for all loops.
    The pace of a loop is ignored, and calls that other threads make on a loop are not held back until the end
    of a step.

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
                waiting = self._each(dict(enumerate(partial(_step, loop) for loop in loops)), failed)
            else:
                for part, pool in ((ClosedLoop.begin_step, None), (ClosedLoop.advance_in_turn, self._pool)):
                    self._each({n: partial(part, loop) for n, loop in enumerate(loops)}, failed, pool)
                waiting = self._each({n: partial(_end, loop) for n, loop in enumerate(loops)}, failed)
            while waiting:
                waiting |= self._each(_continuations(waiting, limit), failed)
        for number in failed:
            loops[number].is_stepping = False
        return dict(sorted(failed.items()))

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _each(
        self,
        parts: Mapping[int, Callable[[], Waiting | None]],
        failed: dict[int, Exception],
        pool: ThreadPoolExecutor | None = None,
    ) -> dict[int, Waiting]:
        """Take a part of the step of each loop that has not failed, on the threads of the pool, if any.

        Returns:
            The loops that wait for a call.
        """
        waiting: dict[int, Waiting] = {}

        def work(share: Sequence[int]) -> None:
            for number in share:
                if number not in failed:
                    try:
                        if (waits := parts[number]()) is not None:
                            waiting[number] = waits
                    except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                        failed[number] = error

        n = self.threads if pool is not None else 1
        shares = [[*parts][first::n] for first in range(n)]
        list(pool.map(work, shares) if pool is not None else map(work, shares))
        return waiting


def _step(loop: ClosedLoop) -> Waiting | None:
    loop.begin_step()
    loop.advance_in_turn()
    return _end(loop)


def _end(loop: ClosedLoop) -> Waiting | None:
    ending = loop.end_step(together=True)
    return _waits(ending, partial(next, ending))


def _waits(ending: EndOfStep, go_on: Callable[[], VectorizedCall]) -> Waiting | None:
    """Continue the end of a step; return the call that it waits for, if any."""
    try:
        return ending, go_on()
    except StopIteration:
        return None


def _continuations(
    waiting: dict[int, Waiting], limit: time_limit.TimeLimit
) -> dict[int, Callable[[], Waiting | None]]:
    """Make the call that the first loop waits for; return how it continues, and all that wait for the same.

    These are removed from those that wait.
    """
    kind = _kind(next(iter(waiting.values())))
    numbers = [number for number, waits in waiting.items() if _kind(waits) == kind]
    endings, calls = zip(*map(waiting.pop, numbers), strict=True)
    steps: list[Callable[[], Any]]
    began = time.perf_counter_ns()
    try:
        results = limit.call(call_for_copies, calls)
        share_ns = (time.perf_counter_ns() - began) // len(calls)
        steps = [partial(end.send, (row, share_ns)) for end, row in zip(endings, results, strict=True)]
    except BaseException as error:  # noqa: BLE001 - each loop treats it as an error of its own
        steps = [partial(ending.throw, error) for ending in endings]
    parts = (partial(_waits, ending, step) for ending, step in zip(endings, steps, strict=True))
    return dict(zip(numbers, parts, strict=True))


def _kind(waits: Waiting) -> tuple[str, Any]:
    """Return the name and the code of the function that is called; one copy may have other code."""
    function = waits[1][0]
    return function.name, inspect.unwrap(function.function).__code__
