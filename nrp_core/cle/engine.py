"""The closed loop engine.

In one step, brain and world advance over ``(t, t + period]`` with the inputs written at ``t``; then the
transfer functions run. They see both sides at ``t + period``, and their outputs act from then on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from typing import Any, Literal, TypeVar

from nrp_core._support.closing import Closing
from nrp_core._support.stopwatch import work
from nrp_core.brain.interface import Brain
from nrp_core.cle.account import TimeAccount
from nrp_core.cle.failures import Failure
from nrp_core.cle.hooks import Hooks
from nrp_core.cle.interrupts import DeferredInterrupt
from nrp_core.cle.latency import LoopPath, paths
from nrp_core.cle.pacing import AsFastAsPossible, Pacing
from nrp_core.cle.requests import Requests
from nrp_core.cle.sides import Sides
from nrp_core.cle.time_limit import DEFAULT_S, TimeLimit, TimeLimitExceeded
from nrp_core.cle.wiring import Wiring
from nrp_core.clock import StepPlan, milliseconds, seconds
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.errors import ExperimentError, LifecycleError, SimulationError, TimestepError
from nrp_core.world.topics import Publication, check_message
from nrp_core.world.world import World

T = TypeVar("T")


class ClosedLoop(Closing):
    """A brain and a world, coupled by transfer functions. Closing the loop closes neither of them.

    Args:
        brain: the brain.
        world: the world, at the same time as the brain.
        functions: transfer functions; those of equal priority run in this order.
        period_ns: one step of the loop.
        tf_time: the time that functions get: the ``end`` of the step, which is the time of their data,
            or its ``start``.
        on_error: the reaction to a function that raises: the run ``stop``s, or the function is put in
            ``quarantine`` (it does not run again, its devices fall silent) and the others continue.
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
        tf_time: Literal["end", "start"] = "end",
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
        self.is_stepping = False
        self._sides = Sides(brain, world, concurrent=concurrent)
        self._published: deque[tuple[Publication, Any]] = deque()
        self._stopping = False

    @property
    def functions(self) -> tuple[TransferFunction, ...]:
        """The transfer functions in the order in which they run."""
        return self._wiring.functions

    @property
    def now_ns(self) -> int:
        """The time that brain and world have reached, ns."""
        return min(self.brain.now_ns, self.world.now_ns)  # they differ after one of them failed

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

    def stop(self) -> None:
        """End the run after its current step; any thread or hook may call this, between two steps too."""
        self._stopping = True

    def _step(self) -> None:
        began = work.now_ns()
        try:
            self.begin_step()
            self._sides.advance(self.now_ns + self.plan.period_ns, self.account)
            failure = self.end_step()
        finally:
            self.is_stepping = False
            self.account.total_ns += work.now_ns() - began
        if failure is not None:
            raise failure.to_error() from failure.error

    # -- the parts of a step, which many loops take together; see SideBySide

    def begin_step(self) -> None:
        """Deliver messages from outside, and call the hooks before a step."""
        self.is_stepping = True
        if self._published:
            self._deliver_published()
        self._call(self.hooks.before_step)

    def advance_in_turn(self) -> None:
        """Bring first the brain, then the world to the end of the step, on the calling thread."""
        self._sides.advance_in_turn(self.now_ns + self.plan.period_ns, self.account)

    def end_step(self) -> Failure | None:
        """Run the functions and hooks after a step, and return the failure that ends the run, if any."""
        self.steps += 1
        self._call(self.hooks.before_functions)
        failure = self._run_functions()
        self._call(self.hooks.after_step)
        self.is_stepping = False
        return failure

    # -- within a step

    def _run_functions(self) -> Failure | None:
        """Run the functions that are due and return the failure that ends the run, if any."""
        now_ns = self.now_ns
        start_ns = now_ns - self.plan.period_ns
        t = seconds(now_ns if self.tf_time == "end" else start_ns)
        for function in self.functions:
            if not (function.is_bound and function.is_due(start_ns)):
                continue  # a function removed in this step is no longer bound
            began = work.now_ns()
            failure = self._run(function, now_ns, t)
            self.account.function_ns[function.name] += work.now_ns() - began
            self.account.function_calls[function.name] += 1
            if failure is not None:
                self.failures.append(failure)
                if self.on_error == "stop":
                    return failure
                function.active = False
        return None

    def _run(self, function: TransferFunction, now_ns: int, t: float) -> Failure | None:
        try:
            self.time_limit.call(function.run, now_ns, t)
        except (SimulationError, LifecycleError):
            raise  # an engine failed while the function used it
        except (Exception, SystemExit, TimeLimitExceeded) as error:  # noqa: BLE001 - whatever users write may raise anything
            return Failure.of(function, error, step=self.steps, t_ns=now_ns)
        return None

    def _call(self, hooks: list[Callable[[ClosedLoop], None]]) -> None:
        for hook in hooks:
            hook(self)

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

    def attended(self) -> AbstractContextManager[None]:
        """Let this thread make the calls of all others until the end of the block, between runs too."""
        return self._requests.running()

    def attend(self, longest_s: float) -> None:
        """Make the calls of other threads; wait for one if there is none.

        Args:
            longest_s: wall time after which it returns without a call, s.
        """
        self._requests.wait(longest_s)

    def change(self, add: Iterable[TransferFunction] = (), remove: Iterable[str] = ()) -> None:
        """Add, replace and remove functions between two steps; if anything is wrong, change nothing.

        A function replaces the one of the same name: variables keep their values, devices keep their state
        and their random streams. A function in quarantine runs again once it is replaced. Any thread may
        call this.

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
            ExperimentError: there is no function of this name, or ``active`` is not true or false.
        """
        if not isinstance(active, bool):
            raise ExperimentError(f"'{name}' is made active by True, inactive by False, not by {active!r}")
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
        self._call(self.hooks.after_reset)

    def save(self) -> Any:
        """Return the state of the loop and of its functions; brain and world save theirs themselves."""
        return self.steps, {function.name: function.save() for function in self.functions}

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`; brain and world must have been restored before.

        Functions that are not in the saved state stay as they are.
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
        self._sides.close()
