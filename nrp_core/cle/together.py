"""The ends of the steps of many loops, in which vectorised functions are called once for all loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from nrp_core._support.stopwatch import work
from nrp_core._support.time_limit import TimeLimitExceeded
from nrp_core.brain.together import BrainBatch as BrainBatch
from nrp_core.cle.loop import ClosedLoop, Failure
from nrp_core.dsl.calls import Call
from nrp_core.dsl.functions import TransferFunction, call_for_copies
from nrp_core.errors import LifecycleError, SimulationError
from nrp_core.simulation import Failures
from nrp_core.world.batch import release_together

Calling: TypeAlias = tuple["_End", TransferFunction, Iterator[Call]]
Prepared: TypeAlias = tuple["_End", TransferFunction, float]


class _End:
    """The end of the step of one loop.

    Attributes:
        number: the number of the loop.
        changing: the functions whose changes wait until all functions have run.
        is_over: whether no further function runs.
        ended: the function of which a call failed last: its further calls are not made.
    """

    ended: TransferFunction | None = None

    def __init__(self, number: int, loop: ClosedLoop) -> None:
        loop.steps += 1
        for hook in loop.hooks.before_functions:
            hook(loop)
        self.number, self.loop, self.functions = number, loop, loop.functions
        self.n_failures, self.is_over = len(loop.failures), False
        self.changing: list[TransferFunction] = []
        self.now_ns = loop.now_ns
        self.start_ns = self.now_ns - loop.plan.period_ns
        self.t = loop.function_time(self.now_ns, self.start_ns)

    def stop_after(self, function: TransferFunction) -> None:
        """Run no further function after one that failed, if that ends the run."""
        if self.loop.on_error == "stop":
            self.is_over = True
            if function in self.changing:
                self.changing.remove(function)


class EndsOfSteps:
    """Ends the steps of loops, each with the results that it has alone.

    The functions at the same place in their loops run one after the other, in the order of the loops.
    """

    def __init__(self) -> None:
        self._kinds: dict[TransferFunction, int] = {}
        self._known: dict[Any, int] = {}
        self._observing: dict[Any, Any] = {}

    def end(self, loops: Mapping[int, ClosedLoop], failed: Failures) -> None:
        """End the steps of loops by their numbers; one that fails does not stop the others."""
        ends: list[_End] = []
        for number, loop in loops.items():
            try:
                ends.append(_End(number, loop))
                loop.world.hold_messages()
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                failed[number] = error
        try:
            for place in range(max((len(end.functions) for end in ends), default=0)):
                self._run(place, ends, failed)
        finally:
            lost = release_together([end.loop.world for end in ends])
        failed |= {ends[place].number: error for place, error in lost.items()}
        ends = [end for end in ends if end.number not in failed]
        failures: dict[int, Failure | None] = {}
        for end in ends:
            has_more = end.changing or len(end.loop.failures) > end.n_failures
            try:
                changed = end.loop.deliver_changes(end.changing, end.n_failures) if has_more else None
                failures[end.number] = changed
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                failed[end.number] = error
        ends = [end for end in ends if end.number not in failed]
        self._observe([end.loop for end in ends])
        for end in ends:
            try:
                end.loop.complete_step(failures[end.number])
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                failed[end.number] = error

    def _run(self, place: int, ends: Sequence[_End], failed: Failures) -> None:
        """Run the functions at a place in their loops, if they are due."""
        calling: list[Calling] = []
        for end in ends:
            if end.is_over or place >= len(end.functions) or end.number in failed:
                continue
            function = end.functions[place]
            if not function.is_bound:
                continue  # it was removed in this step
            if function.deferring:
                end.changing.append(function)
            try:
                calls = function.calls_due(end.start_ns, end.t)
                if calls and function.vectorized:
                    calling.append((end, function, iter(calls)))
                elif calls and not end.loop.make_calls(function, calls, end.now_ns, end.t):
                    end.stop_after(function)
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                failed[end.number] = error
        while calling:
            calling = self._call_vectorized(calling, failed)

    def _call_vectorized(self, calling: Sequence[Calling], failed: Failures) -> list[Calling]:
        """Make the next call of each function; return the functions that may have another one."""
        batches: dict[Any, list[Prepared]] = {}
        going: list[Calling] = []
        for one in calling:
            end, function, calls = one
            try:
                if (call := next(calls, None)) is None:
                    continue
            except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                failed[end.number] = error
                continue
            try:
                if function.runs_users_code:
                    limit = end.loop.time_limit
                    prepared = limit.call(function.prepare, end.now_ns, end.t, call)
                else:
                    prepared = function.prepare(end.now_ns, end.t, call)
            except (Exception, SystemExit, TimeLimitExceeded) as error:  # noqa: BLE001 - whatever users write may raise anything
                end.loop.account.function_calls[function.name] += 1
                _note(end, function, error, failed)
                continue
            kind = end.loop.time_limit, self._kind(function)
            batches.setdefault(kind, []).append((end, function, prepared))
            going.append(one)
        for batch in batches.values():
            _call(batch, failed)
        return [
            (end, function, calls)
            for end, function, calls in going
            if not end.is_over and end.ended is not function and end.number not in failed
        ]

    def _kind(self, function: TransferFunction) -> int:
        """Return a number that is equal for functions which one call can run; one copy may have others."""
        kind = self._kinds.get(function)
        if kind is None:
            known = function.name, function.__code__, function.origin
            kind = self._kinds[function] = self._known.setdefault(known, len(self._known))
        return kind

    def _observe(self, loops: Sequence[ClosedLoop]) -> None:
        """Call the observers of several loops that can observe them at once."""
        observers: dict[Any, list[Any]] = {}
        for loop in loops:
            for make, observer in loop.hooks.together:
                observers.setdefault(make, []).append(observer)
        for make, each in observers.items():
            if make not in self._observing:
                self._observing[make] = make()
            self._observing[make].evaluate(each)


def _call(batch: Sequence[Prepared], failed: Failures) -> None:
    """Call a vectorised function once for the loops of a batch."""
    began, limit = work.now_ns(), batch[0][0].loop.time_limit
    calls = [(function, prepared) for _, function, prepared in batch]
    error: BaseException | None = None
    try:
        results = limit.call(call_for_copies, calls)
    except (Exception, SystemExit, TimeLimitExceeded) as raised:  # noqa: BLE001 - whatever users write may raise anything
        results, error = [None] * len(batch), raised
    for (end, function, _), result in zip(batch, results, strict=True):
        try:
            if error is not None:
                raise error
            if function.runs_users_code:
                limit.call(function.complete, result)
            else:
                function.complete(result)
        except (Exception, SystemExit, TimeLimitExceeded) as own:  # noqa: BLE001 - as above
            _note(end, function, own, failed)
    share_ns = (work.now_ns() - began) // len(batch)
    for end, function, _ in batch:
        account = end.loop.account
        account.function_ns[function.name] += share_ns
        account.function_calls[function.name] += 1


def _note(end: _End, function: TransferFunction, error: BaseException, failed: Failures) -> None:
    """Note that a call has failed: the function, or an engine while the function used it."""
    if isinstance(error, (SimulationError, LifecycleError)):
        failed[end.number] = error
    else:
        end.ended = function
        end.loop.note_failure(function, error)
        end.stop_after(function)
