"""Steps of many loops at once, for copies of an experiment in one process."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from nrp_core._support.closing import Closing
from nrp_core._support.stopwatch import work
from nrp_core.cle.engine import ClosedLoop, Failure
from nrp_core.cle.time_limit import DeferredInterrupt
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
        shared = {name: functions.together.reason for name, functions in self._together.items()}
        return {name: reason for name, reason in shared.items() if reason}

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
            self._each(loops, ClosedLoop.begin_functions, failed)
            ended = self._run_functions(loops, failed)
            self._each(loops, ClosedLoop.end_functions, failed)
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
        alike: dict[tuple[object, ...], list[int]] = {}
        for number, loop in enumerate(loops):
            if number not in failed:
                alike.setdefault((loop.function_names, loop.now_ns, loop.tf_time), []).append(number)
        for (names, *_), numbers in alike.items():
            columns = zip(*[loops[number].functions for number in numbers], strict=True)
            for name, column in zip(names, columns, strict=True):  # type: ignore[call-overload]
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
        """Run one function in the loops in which it is due, all of them at the same time."""

        def attempt(number: int, call: Callable[..., object], *given: object) -> None:
            try:
                failure = loops[number].attempt(functions[number], call, *given)
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                _fail(loops, number, error, failed)
                return
            if failure is not None:
                ended[number] = failure

        stopped = failed.keys() | ended.keys()
        due = [
            number
            for number in functions
            if number not in stopped and loops[number].is_due(functions[number])
        ]
        if not due:
            return
        now_ns, t_s = loops[due[0]].now_ns, loops[due[0]].function_time_s
        failures = [len(loops[number].failures) for number in due]
        for number in due:
            loops[number].account.function_calls[name] += 1
            if functions[number].is_refreshed:
                attempt(number, functions[number].refresh, now_ns)
        due = [
            number
            for number, before in zip(due, failures, strict=True)
            if number not in failed and len(loops[number].failures) == before
        ]
        chosen = [functions[number] for number in due]
        began = work.now_ns()
        if not self._functions(name, functions).run(chosen, t_s):
            for number in due:
                attempt(number, functions[number].compute, t_s)
            return
        each_ns = (work.now_ns() - began) // len(due)
        for number in due:
            loops[number].account.function_ns[name] += each_ns

    def _functions(self, name: str, functions: Mapping[int, TransferFunction]) -> FunctionTogether:
        """Return what calls a function for all loops; it is proved again if the function of a loop is new."""
        known = self._together.get(name)
        if known is None or not known.has(functions):
            known = self._together[name] = _Functions(list(functions.values()))
        return known.together


class _Functions:
    """The functions of a name in all loops."""

    def __init__(self, functions: Sequence[TransferFunction]) -> None:
        self._known = {id(function): function for function in functions}
        self.together = FunctionTogether(functions)

    def has(self, functions: Mapping[int, TransferFunction]) -> bool:
        return all(id(function) in self._known for function in functions.values())


def _fail(loops: Sequence[ClosedLoop], number: int, error: Exception, failed: Failed) -> None:
    loops[number].is_stepping = False
    failed[number] = error


def _advance(loop: ClosedLoop) -> None:
    loop.begin_step()
    loop.advance_in_turn()
