"""The closed loop engine.

In one step, brain and world advance over ``(t, t + period]`` with the inputs written at ``t``; then the
transfer functions run. They see both sides at ``t + period``, and their outputs act from then on.
"""

from __future__ import annotations

import threading
from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Literal, Protocol, TypeVar

from nrp_core._support.closing import Closing
from nrp_core._support.machine import cores
from nrp_core._support.stopwatch import work
from nrp_core._support.time_limit import DEFAULT_S, DeferredInterrupt, TimeLimit, TimeLimitExceeded
from nrp_core.brain.interface import Brain
from nrp_core.cle.latency import LoopPath, paths
from nrp_core.cle.pacing import AsFastAsPossible, Pacing
from nrp_core.cle.wiring import Wiring
from nrp_core.clock import StepPlan, milliseconds, seconds
from nrp_core.dsl.calls import Call
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.parameters import line_in
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    LifecycleError,
    NetworkError,
    SimulationError,
    TimestepError,
    TransferFunctionRaisedError,
)
from nrp_core.world.topics import Publication, check_message
from nrp_core.world.world import World


@dataclass(slots=True)
class TimeAccount:
    """Wall time spent since the last reset, ns; pacing and compilation are not counted.

    Attributes:
        brain_ns: advancing the brain.
        world_ns: advancing the world.
        both_ns: advancing both; less than the sum of the two where they ran at once.
        function_ns: running each transfer function, by name.
        function_calls: how often each transfer function ran, by name.
        total_ns: all steps as a whole; a step is added when it ends.
    """

    brain_ns: int = 0
    world_ns: int = 0
    both_ns: int = 0
    function_ns: defaultdict[str, int] = field(default_factory=lambda: defaultdict(int))
    function_calls: defaultdict[str, int] = field(default_factory=lambda: defaultdict(int))
    total_ns: int = 0

    @property
    def functions_ns(self) -> int:
        """All transfer functions together."""
        return sum(self.function_ns.values())

    @property
    def engine_ns(self) -> int:
        """The loop itself, hooks included; 0 while the first step is under way."""
        return max(0, self.total_ns - self.both_ns - self.functions_ns)

    def add(self, brain_ns: int, world_ns: int, both_ns: int | None = None) -> None:
        """Add the time of both sides in a step, and of the step of both if they ran at once."""
        self.brain_ns += brain_ns
        self.world_ns += world_ns
        self.both_ns += brain_ns + world_ns if both_ns is None else both_ns

    def shares(self) -> dict[str, float]:
        """Return the share of each part; the shares add up to 1 (all are 0 before the first step)."""
        work = {
            "brain": self.brain_ns,
            "world": self.world_ns,
            "transfer_functions": self.functions_ns,
            "engine": self.engine_ns,
        }
        total = sum(work.values()) or 1
        return {name: spent / total for name, spent in work.items()}


Loop = TypeVar("Loop")


class ObservesMany(Protocol):
    """Observes many loops at once."""

    def evaluate(self, observers: Sequence[Any]) -> None:
        """Observe the present time for observers of one loop each."""


@dataclass(frozen=True, slots=True)
class Hooks(Generic[Loop]):
    """Lists of functions, called in order; an exception in one ends the run.

    Attributes:
        before_step: called at the start of a step; messages published now act in this step.
        before_functions: called when brain and world have advanced, before the transfer functions run.
        after_step: called after the transfer functions, also if one of them failed.
        after_reset: called when everything is back at time 0.
        from_outside: called with topic and message before a message from outside is published.
        together: observers of which many can observe at once, before ``after_step``, and what makes the
            object that does so.
    """

    before_step: list[Callable[[Loop], None]] = field(default_factory=list)
    before_functions: list[Callable[[Loop], None]] = field(default_factory=list)
    after_step: list[Callable[[Loop], None]] = field(default_factory=list)
    after_reset: list[Callable[[Loop], None]] = field(default_factory=list)
    from_outside: list[Callable[[str, Any], None]] = field(default_factory=list)
    together: list[tuple[Callable[[], ObservesMany], Any]] = field(default_factory=list)


T = TypeVar("T")


class Requests:
    """While a thread runs or attends the loop, it executes the calls of others; otherwise each its own."""

    def __init__(self) -> None:
        self._changed = threading.Condition(threading.RLock())  # calls may be nested
        self._waiting: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._runner: int | None = None

    def make(self, call: Callable[[], T]) -> T:
        """Make a call between two steps; return its result or raise its exception."""
        if self._runner == threading.get_ident():
            return call()
        with self._changed:
            if self._runner is None:
                return call()
            future: Future[T] = Future()
            self._waiting.append((call, future))
            self._changed.notify_all()
        return future.result()

    @contextmanager
    def running(self) -> Iterator[None]:
        """Make this thread execute the calls; it executes the waiting calls at the end."""
        with self._changed:
            before, self._runner = self._runner, threading.get_ident()
        try:
            yield
        finally:
            with self._changed:
                self.serve()
                self._runner = before

    def wait(self, longest_s: float) -> None:
        """Execute the pending calls; if there are none, wait for one."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting, longest_s)
        self.serve()

    def serve(self) -> None:
        """Make the pending calls."""
        while self._waiting:
            call, future = self._waiting.popleft()
            try:
                future.set_result(call())
            except BaseException as error:  # noqa: BLE001 - it belongs to whoever waits for the result
                future.set_exception(error)


@dataclass(frozen=True, slots=True)
class Failure:
    """A transfer function that raised, did not return, or returned a value that its topic cannot carry.

    Args:
        function: its name.
        path: its file.
        line: the line; for a function that did not return, the line that was running.
        step: number of the step, starting at 1.
        t_ns: the time that brain and world had reached.
        error: the exception.
        inputs: the values of its parameters.
    """

    function: str
    path: Path
    line: int
    step: int
    t_ns: int
    error: BaseException
    inputs: dict[str, str]

    @classmethod
    def of(cls, function: TransferFunction, error: BaseException, *, step: int, t_ns: int) -> Failure:
        """Return a description of the failure."""
        path = function.place.path
        line = line_in(error.__traceback__, path) or function.place.line
        return cls(function.name, Path(path), line, step, t_ns, error, function.inputs())

    def __str__(self) -> str:
        return "\n".join([
            f"{self.path}:{self.line}: transfer function '{self.function}' {self.reason}{self.notes}",
            f"  in step {self.step}, at {seconds(self.t_ns):g} s{', with' if self.inputs else ''}",
            *(f"    {name}: {seen}" for name, seen in self.inputs.items()),
        ])  # fmt: skip

    @property
    def reason(self) -> str:
        """The failure as the rest of a sentence that begins with the function."""
        error = self.error
        message = error.message if isinstance(error, ExperimentError) else str(error)
        if isinstance(error, TimeLimitExceeded):
            return message
        return f"raised {type(error).__name__}{': ' if message else ''}{message}"

    @property
    def notes(self) -> str:
        """The notes of the exception, to complete the sentence; empty without notes."""
        return "".join(f"; {note}" for note in getattr(self.error, "__notes__", ()))

    def to_error(self) -> TransferFunctionRaisedError:
        """Return the error that stops a run."""
        return TransferFunctionRaisedError(str(self), t_ns=self.t_ns)


WORTH_A_THREAD_NS = 500_000
"""Both sides must take at least this long for a thread to pay off; a handover costs about 100 us."""


class CoupledStep:
    """A brain and a world that advance together.

    The world stays on the calling thread, because its renderers are bound to one; the brain runs on a
    thread of its own. Neither sees the other within a step, so the result does not depend on this.

    Args:
        brain: the brain.
        world: the world.
        concurrent: whether to use a thread; None: if the brain releases the GIL and the duration of the
            last step makes it worthwhile.
    """

    def __init__(self, brain: Brain, world: World, *, concurrent: bool | None = None) -> None:
        self._brain, self._world = brain, world
        can = brain.capabilities.releases_gil and cores() > 1
        self._concurrent = False if concurrent is None and not can else concurrent
        self._thread = ThreadPoolExecutor(1, "brain")
        self._last_ns = 0

    def advance(self, t_ns: int, account: TimeAccount) -> None:
        """Advance brain and world to ``t_ns``.

        Raises:
            BaseException: the exception of either side, after both have stopped.
        """
        began = work.now_ns()
        together = self._last_ns >= WORTH_A_THREAD_NS if self._concurrent is None else self._concurrent
        if together:
            brain_ns, world_ns = self._together(t_ns)
        else:
            self._brain.run_until(t_ns)
            between = work.now_ns()
            self._world.run_until(t_ns)
            brain_ns, world_ns = between - began, work.now_ns() - between
        self._last_ns = min(brain_ns, world_ns)
        account.add(brain_ns, world_ns, work.now_ns() - began)

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown()

    def _together(self, t_ns: int) -> tuple[int, int]:
        brain = self._thread.submit(_timed, self._brain, t_ns)
        try:
            world_ns = _timed(self._world, t_ns)
        except BaseException as error:
            failure = brain.exception()
            if failure is not None:
                error.add_note(f"the brain failed too: {failure}")
            raise
        return brain.result(), world_ns


def _timed(side: Brain | World, t_ns: int) -> int:
    began = work.now_ns()
    side.run_until(t_ns)
    return work.now_ns() - began


class ClosedLoop(Closing):
    """A brain and a world, coupled by transfer functions. Closing the loop closes neither of them.

    Args:
        brain: the brain.
        world: the world, at the same time as the brain.
        functions: transfer functions; those of equal priority run in this order.
        period_ns: one step of the loop.
        tf_time: the time that functions get: the ``end`` of the step, which is the time of their data,
            its ``start``, or the start as the ``summed`` steps in floating point.
        on_error: the reaction to a function that raises: the run ``stop``s, or the function is put in
            ``quarantine`` (it does not run again, its devices fall silent, nothing is sampled for it) and
            the others continue.
        function_time_limit_s: wall time that one call of a function may take, s; a longer call is
            interrupted and counts as failed. None: no limit.
        pacing: how fast time passes; by default as fast as possible.
        concurrent: whether brain and world advance in parallel; None: if it is faster.

    Attributes:
        steps: number of steps taken.
        is_stepping: whether a step is in progress.
        time_limit: interrupts functions that do not return; loops that are stepped together share one.

    Raises:
        TimestepError: the period is not a multiple of the steps of both sides.
        ExperimentError: a function names something that does not exist.
        LifecycleError: brain and world are not at the same time.
    """

    def __init__(
        self,
        brain: Brain,
        world: World,
        functions: Iterable[TransferFunction] = (),
        *,
        period_ns: int,
        tf_time: Literal["end", "start", "summed"] = "end",
        on_error: Literal["stop", "quarantine"] = "stop",
        function_time_limit_s: float | None = DEFAULT_S,
        pacing: Pacing | None = None,
        concurrent: bool | None = None,
    ) -> None:
        self.plan = StepPlan(period_ns, brain.capabilities.resolution_ns, world.capabilities.step_ns)
        if brain.now_ns != world.now_ns:
            at = f"{seconds(brain.now_ns):g} s and {seconds(world.now_ns):g} s"
            raise LifecycleError(f"brain and world must be at the same time, not at {at}")
        self.brain, self.world = brain, world
        self._wiring = Wiring(brain, world)
        self._wiring.change(functions)
        self._requests = Requests()
        self.tf_time, self.on_error = tf_time, on_error
        self.time_limit = TimeLimit(function_time_limit_s)
        self.pacing = AsFastAsPossible() if pacing is None else pacing
        self.hooks: Hooks[ClosedLoop] = Hooks()
        self.account = TimeAccount()
        self.failures: list[Failure] = []
        self.steps = 0
        self._summed = 0, 0.0
        self.is_stepping = False
        self._coupled = CoupledStep(brain, world, concurrent=concurrent)
        self._published: deque[tuple[Publication, Any]] = deque()
        self._stopping = False

    @property
    def functions(self) -> tuple[TransferFunction, ...]:
        """The transfer functions in the order in which they run."""
        return self._wiring.functions

    @property
    def now_ns(self) -> int:
        """The time that brain and world have reached, ns."""
        brain_ns, world_ns = self.brain.now_ns, self.world.now_ns
        return brain_ns if brain_ns < world_ns else world_ns  # they differ after one of them failed

    # -- running

    def step(self) -> None:
        """Take one step; see :meth:`run_until`."""
        self.run_until(self.now_ns + self.plan.period_ns)

    def run_until(self, t_ns: int) -> None:
        """Take steps until ``t_ns`` or until :meth:`stop`. Ctrl-C ends the run between two steps.

        Raises:
            TimestepError: ``t_ns`` is not a whole number of steps away.
            TransferFunctionRaisedError: a function raised or did not return (with ``on_error="stop"``);
                its exception is the cause.
            SimulationError: an engine failed.
        """
        if (t_ns - self.now_ns) % self.plan.period_ns:
            raise TimestepError(
                f"{seconds(t_ns):g} s is not a whole number of steps of "
                f"{milliseconds(self.plan.period_ns):g} ms after {seconds(self.now_ns):g} s"
            )
        self._stopping = False
        self.pacing.start(self.now_ns)
        with self._requests.running(), self.time_limit.watching():
            while self.now_ns < t_ns and not self._stopping:
                with DeferredInterrupt():
                    self._requests.serve()
                    if self._stopping:
                        break
                    self._step()
                self.pacing.wait(self.now_ns)

    @property
    def is_stopping(self) -> bool:
        """Whether :meth:`stop` was called since the last run began, or the last reset."""
        return self._stopping

    def stop(self) -> None:
        """End the run after its current step; any thread or hook may call this, between two steps too."""
        self._stopping = True

    def _step(self) -> None:
        began = work.now_ns()
        try:
            self.begin_step()
            self._coupled.advance(self.now_ns + self.plan.period_ns, self.account)
            self.complete_step(self._run_functions())
        finally:
            self.is_stepping = False
            self.account.total_ns += work.now_ns() - began

    # -- the parts of a step, which many loops take together; see EndsOfSteps

    def begin_step(self) -> None:
        """Deliver messages from outside, and call the hooks before a step."""
        self.is_stepping = True
        if self._published:
            self._deliver_published()
        for hook in self.hooks.before_step:
            hook(self)

    def complete_step(self, failure: Failure | None) -> None:
        """Call the hooks after a step.

        Raises:
            TransferFunctionRaisedError: a function has failed.
        """
        for hook in self.hooks.after_step:
            hook(self)
        self.is_stepping = False
        if failure is not None:
            raise failure.to_error() from failure.error

    def deliver_changes(self, functions: Iterable[TransferFunction], n_failures: int) -> Failure | None:
        """Deliver what functions have changed; return the failure that ends the run, if any.

        Args:
            functions: the functions.
            n_failures: the number of failures before the step.
        """
        for function in functions:
            try:
                function.deliver()  # nothing if it has failed
            except (NetworkError, CapabilityError) as error:
                self.note_failure(function, error)
        failed = self.on_error == "stop" and len(self.failures) > n_failures
        return self.failures[n_failures] if failed else None

    def make_calls(self, function: TransferFunction, calls: Iterable[Call], now_ns: int, t: float) -> bool:
        """Make the calls of a function in this step, and return whether all succeeded."""
        for call in calls:
            began, failed = work.now_ns(), False
            try:
                self.time_limit.call(function.run, now_ns, t, call)
            except (SimulationError, LifecycleError):
                raise  # an engine failed while the function used it
            except (Exception, SystemExit, TimeLimitExceeded) as error:  # noqa: BLE001 - whatever users write may raise anything
                self.note_failure(function, error)
                failed = True
            self.account.function_ns[function.name] += work.now_ns() - began
            self.account.function_calls[function.name] += 1
            if failed:
                return False
        return True

    def function_time(self, now_ns: int, start_ns: int) -> float:
        """Return the time that is passed to functions, s."""
        if self.tf_time != "summed":
            return seconds(now_ns if self.tf_time == "end" else start_ns)
        steps = start_ns // self.plan.period_ns
        n, t = self._summed if self._summed[0] <= steps else (0, 0.0)
        for _ in range(steps - n):
            t += seconds(self.plan.period_ns)
        self._summed = steps, t
        return t

    def note_failure(self, function: TransferFunction, error: BaseException) -> None:
        """Keep the failure of a function, and put it in quarantine if the run continues."""
        self.failures.append(Failure.of(function, error, step=self.steps, t_ns=self.now_ns))
        if self.on_error == "quarantine":
            function.quarantine()

    # -- within a step

    def _run_functions(self) -> Failure | None:
        """Call the hooks and run the functions that are due; return the failure that ends the run, if any.

        What they publish and change is delivered when all of them have run, so their order does not matter.
        """
        self.steps += 1
        for hook in self.hooks.before_functions:
            hook(self)
        if not self.functions:
            return None
        n_before, changing, now_ns = len(self.failures), [], self.now_ns
        start_ns = now_ns - self.plan.period_ns
        t = self.function_time(now_ns, start_ns)
        self.world.hold_messages()
        try:
            for function in self.functions:
                if not function.is_bound:
                    continue  # it was removed in this step
                calls = function.calls_due(start_ns, t)
                if calls and not self.make_calls(function, calls, now_ns, t) and self.on_error == "stop":
                    break
                if function.deferring:
                    changing.append(function)
        finally:
            self.world.release_messages()
        has_more = changing or len(self.failures) > n_before
        return self.deliver_changes(changing, n_before) if has_more else None

    # -- from outside

    def publish(self, topic: str, message: Any) -> None:
        """Publish on a topic of the world before the next step; any thread may.

        Raises:
            TopicError: the topic does not exist or cannot carry the message.
        """
        publication = self.world.advertise(topic)
        check_message(publication.topic, message)
        self._published.append((publication, message))

    @property
    def waiting(self) -> list[str]:
        """The topics of the messages from outside that wait for the next step."""
        return [publication.topic.name for publication, _ in self._published]

    def _deliver_published(self) -> None:
        while self._published:
            publication, message = self._published.popleft()
            for hook in self.hooks.from_outside:
                hook(publication.topic.name, message)
            publication.publish(message)

    def between_steps(self, call: Callable[[], T]) -> T:
        """Make a call between two steps and return its result; any thread may call this."""
        return self._requests.make(call)

    def serving_calls(self) -> AbstractContextManager[None]:
        """Let this thread make the calls of all others until the end of the block, between runs too."""
        return self._requests.running()

    def attend(self, longest_s: float) -> None:
        """Execute the calls of other threads; if there are none, wait for one.

        Args:
            longest_s: wall time after which it returns without a call, s.
        """
        self._requests.wait(longest_s)

    def change(self, add: Iterable[TransferFunction] = (), remove: Iterable[str] = ()) -> None:
        """Add, replace and remove functions between two steps; if anything is wrong, change nothing.

        A function replaces the function of the same name: variables keep their values, devices keep their
        state and their random streams. A function in quarantine runs again once it is replaced. Any thread
        may call this.

        Args:
            add: functions to add.
            remove: names of functions to remove.

        Raises:
            ExperimentError: a function names something that does not exist, or a name is unknown.
        """
        added = tuple(add)
        self.between_steps(lambda: self._change(added, tuple(remove)))

    def _change(self, add: Sequence[TransferFunction], remove: Sequence[str]) -> None:
        self._wiring.change(add, remove)
        self._resume(add)

    def activate(self, name: str, active: bool = True) -> None:
        """Activate or deactivate a transfer function between two steps; any thread may call this.

        Raises:
            ExperimentError: no function has this name, or ``active`` is not true or false.
        """
        if not isinstance(active, bool):
            raise ExperimentError(
                f"'{name}' is activated by True and deactivated by False, not by {active!r}"
            )
        self.between_steps(lambda: setattr(self._wiring[name], "active", active))

    def _resume(self, functions: Iterable[TransferFunction]) -> None:
        """Activate the functions that are active, or were until they failed."""
        failed = {failure.function for failure in self.failures}
        for function in functions:
            function.active = function.active or function.name in failed

    def latency(self) -> list[LoopPath]:
        """Return the number of steps between each sensor and each actuator that it can move."""
        return paths(self.functions)

    # -- life cycle

    def reset(self, *, seed: int | None = None) -> None:
        """Return both sides, variables and failures to time 0; functions in quarantine run again.

        Args:
            seed: a new seed for both sides; by default their seeds stay.
        """
        self.brain.reset(seed=seed)
        self.world.reset(seed=seed)
        for function in self.functions:
            function.reset()
        self._resume(self.functions)
        self.failures.clear()
        self._published.clear()
        self.account = TimeAccount()
        self.steps = 0
        self._stopping = False
        for hook in self.hooks.after_reset:
            hook(self)

    def save(self) -> Any:
        """Return the state of the loop and of its functions; brain and world save theirs themselves."""
        return self.steps, {function.name: function.save() for function in self.functions}

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`; brain and world must have been restored before.

        Functions that the saved state lacks do not change.
        """
        self.steps, functions = saved
        for function in self.functions:
            if function.name in functions:
                function.restore(functions[function.name])
        self.failures.clear()
        self._published.clear()

    def close(self) -> None:
        """Unbind the functions; brain and world stay open."""
        self._wiring.close()
        self._coupled.close()
