"""Steps of many loops at once, for copies of an experiment in one process."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from nrp_core._support.closing import Closing
from nrp_core._support.stopwatch import work
from nrp_core.cle.engine import ClosedLoop, Failure
from nrp_core.cle.time_limit import DeferredInterrupt, TimeLimit, TimeLimitExceeded
from nrp_core.clock import seconds
from nrp_core.dsl.copies.together import FunctionTogether
from nrp_core.dsl.functions import TransferFunction

Failed = dict[int, Exception]
"""Errors by the number of the loop."""


class SideBySide(Closing):
    """Steps independent loops together; each takes the step that it would take alone.

    Brains and worlds of all loops advance on threads. Transfer functions and hooks run on the calling thread,
    because code of users may share values: a function once for all loops where this is proved to be the same
    (:class:`~nrp_core.dsl.copies.together.FunctionTogether`), otherwise loop by loop. The pace of a loop is
    ignored, and calls that other threads make on a loop are not held back until the end of a step.

    Args:
        threads: number of threads; 1: the calling one.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads, "copies") if threads > 1 else None
        self._together: dict[str, _Functions] = {}

    @property
    def one_by_one(self) -> Mapping[str, str]:
        """The transfer functions that run loop by loop, and why."""
        return {name: known.reason for name, known in self._together.items() if known.reason}

    def step(self, loops: Sequence[ClosedLoop]) -> Failed:
        """Take one step of each loop; one that fails does not stop the others.

        Returns:
            The errors of the loops that failed, by their numbers.
        """
        if not loops:
            return {}
        limit = loops[0].time_limit
        for loop in loops:
            loop.time_limit = limit  # a limit of its own for each would be a thread for each
        failed: Failed = {}
        with DeferredInterrupt(), limit.watching():
            if self._pool is None:  # a loop at a time, while the data of its sides are in the fastest caches
                self._each(loops, _advance, failed)
            else:
                self._each(loops, ClosedLoop.begin_step, failed)
                self._each(loops, ClosedLoop.advance_in_turn, failed, self._pool)
            self._each(loops, _begin_functions, failed)
            ended = self._run_functions(loops, failed)
            self._each(loops, _end_functions, failed)
        for number, failure in ended.items():
            if number not in failed:
                failed[number] = failure.to_error()
                failed[number].__cause__ = failure.error
        return dict(sorted(failed.items()))

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _each(
        self,
        loops: Sequence[ClosedLoop],
        part: Callable[[ClosedLoop], None],
        failed: Failed,
        pool: ThreadPoolExecutor | None = None,
    ) -> None:
        """Call a part of the step for each loop that has not failed, on the threads of a pool if given."""

        def work(share: range) -> None:
            for number in share:
                if number not in failed:
                    try:
                        part(loops[number])
                    except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                        _fail(loops, number, error, failed)

        shares = [range(first, len(loops), self.threads) for first in range(self.threads)]
        list(pool.map(work, shares) if pool is not None else map(work, shares))

    def _run_functions(self, loops: Sequence[ClosedLoop], failed: Failed) -> dict[int, Failure]:
        """Run the functions of all loops; return the failures that end runs, by the number of the loop."""
        ended: dict[int, Failure] = {}
        alike: dict[tuple[str, ...], list[int]] = {}
        for number, loop in enumerate(loops):
            if number not in failed:
                alike.setdefault(loop.function_names, []).append(number)
        for names, numbers in alike.items():
            columns = zip(*[loops[number].functions for number in numbers], strict=True)
            for name, column in zip(names, columns, strict=True):
                functions = dict(zip(numbers, column, strict=True))
                self._run_function(name, functions, loops, failed, ended)
        return ended

    def _run_function(
        self,
        name: str,
        functions: Mapping[int, TransferFunction],
        loops: Sequence[ClosedLoop],
        failed: Failed,
        ended: dict[int, Failure],
    ) -> None:
        """Run one function in the loops in which it is due."""

        def attempt(number: int, call: Callable[..., object], *given: object) -> bool:
            loop = loops[number]
            before = len(loop.failures)
            try:
                failure = loop.attempt(functions[number], call, *given)
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                _fail(loops, number, error, failed)
                return False
            if failure is not None:
                ended[number] = failure
            return len(loop.failures) == before

        stopped = failed.keys() | ended.keys()
        due = [
            number
            for number, function in functions.items()
            if number not in stopped and function.is_bound and function.is_due(_start_ns(loops[number]))
        ]
        for number in due:
            loops[number].account.function_calls[name] += 1
        due = [
            number
            for number in due
            if not functions[number].is_refreshed
            or attempt(number, functions[number].refresh, loops[number].now_ns)
        ]
        if not due:
            return
        times_s = [_time_s(loops[number]) for number in due]
        began = work.now_ns()
        if self._done_together(
            name, [functions[number] for number in due], times_s, loops[due[0]].time_limit
        ):
            each_ns = (work.now_ns() - began) // len(due)
            for number in due:
                loops[number].account.function_ns[name] += each_ns
            return
        for number, t_s in zip(due, times_s, strict=True):
            attempt(number, partial(functions[number].run, refresh=False), loops[number].now_ns, t_s)

    def _done_together(
        self, name: str, functions: Sequence[TransferFunction], times_s: Sequence[float], limit: TimeLimit
    ) -> bool:
        """Call a function once for several loops, if possible, and return whether that was done."""
        known = self._together.setdefault(name, _Functions())
        try:
            return limit.call(known.together(functions).run, functions, times_s)
        except TimeLimitExceeded:
            return False  # calls for each loop take too long, too, and one of them is reported


class _Functions:
    """The functions of a name in all loops that were stepped; they are proved again if there is a new one."""

    def __init__(self) -> None:
        self._known: dict[int, TransferFunction] = {}
        self._together: FunctionTogether | None = None

    @property
    def reason(self) -> str:
        return "" if self._together is None else self._together.reason

    def together(self, functions: Sequence[TransferFunction]) -> FunctionTogether:
        """Return what calls them."""
        new = {id(function): function for function in functions if id(function) not in self._known}
        if new or self._together is None:
            kept = {key: function for key, function in self._known.items() if function.is_bound}
            self._known = kept | new
            self._together = FunctionTogether(list(self._known.values()))
        return self._together


def _start_ns(loop: ClosedLoop) -> int:
    return loop.now_ns - loop.plan.period_ns


def _time_s(loop: ClosedLoop) -> float:
    """Return the time that functions get."""
    return seconds(loop.now_ns if loop.tf_time == "end" else _start_ns(loop))


def _fail(loops: Sequence[ClosedLoop], number: int, error: Exception, failed: Failed) -> None:
    loops[number].is_stepping = False
    failed[number] = error


def _advance(loop: ClosedLoop) -> None:
    loop.begin_step()
    loop.advance_in_turn()


def _begin_functions(loop: ClosedLoop) -> None:
    loop.steps += 1
    for hook in loop.hooks.before_functions:
        hook(loop)


def _end_functions(loop: ClosedLoop) -> None:
    for hook in loop.hooks.after_step:
        hook(loop)
    loop.is_stepping = False
