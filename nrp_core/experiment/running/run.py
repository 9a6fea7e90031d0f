"""Run an experiment: open its engines, step the closed loop, evaluate it, and return the result.

::

    with Run(load_experiment("braitenberg_husky", ["seed=3"])) as simulation:
        simulation.run_until(5.0)
        simulation.publish("/screens/left/color", "red")
        simulation.run()
        print(simulation.result().passed)
"""

from __future__ import annotations

import pickle
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.closing import Closing
from nrp_core._support.collector import CollectorPaused
from nrp_core._support.stopwatch import work
from nrp_core.brain.interface import Brain
from nrp_core.cle import ClosedLoop, pacing_of
from nrp_core.clock import seconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import write_csv
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    NrpError,
    SimulationError,
    SnapshotError,
    TimestepError,
)
from nrp_core.experiment.events.criteria import Verdict
from nrp_core.experiment.events.values import to_message
from nrp_core.experiment.making.interventions import Interventions
from nrp_core.experiment.making.maker import load_function_file, maker_of
from nrp_core.experiment.making.prepare import Plan, ProgressCallback, load_network_only, no_progress, prepare
from nrp_core.experiment.making.watch import Watch, declare_missing_topics, declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Build, Experiment
from nrp_core.experiment.running.at_the_end import at_the_end
from nrp_core.experiment.running.falls import FallWatch
from nrp_core.experiment.running.from_outside import watch_outside
from nrp_core.experiment.running.judgement import passed_of
from nrp_core.experiment.running.observation import Observation
from nrp_core.experiment.running.opening import open_beside, open_side
from nrp_core.experiment.running.pace import too_fast
from nrp_core.experiment.running.problems import Reporter, ends_of, not_failed, problems_of, state_of
from nrp_core.experiment.running.resetting import check_part, reset_part
from nrp_core.experiment.running.result import Result, failure_data, pose_data
from nrp_core.experiment.running.silent_topics import SilentTopics
from nrp_core.experiment.running.spike_counts import SpikeCounter
from nrp_core.experiment.running.unheard import UnheardCommands
from nrp_core.experiment.running.until import end_ns
from nrp_core.findings import Finding
from nrp_core.findings.problems import is_complete, without
from nrp_core.paths import path_of
from nrp_core.world.world import World

Added: TypeAlias = Iterable[TransferFunction | Path | str] | TransferFunction | Path | str
"""Functions, or files of functions."""

Observer = Callable[["Run"], None]


class Participant(ABC):
    """A maker of parts that also takes part in the runs of its experiment."""

    @property
    @abstractmethod
    def can_be_saved(self) -> bool:
        """Whether a snapshot of the run contains all of its state."""

    @abstractmethod
    def begin(self, run: Run) -> None:
        """Take part in a run that is about to start, through the hooks of its loop."""


class Run(Closing):
    """An experiment on its two engines, from opening to its result.

    Args:
        experiment: the experiment to run.
        progress: called with the name of each task as it begins during opening.
        revise: returns a changed plan, for example with a recorded engine.
        build: makes the network; by default from the experiment's file.
        beside: an open run of the same experiment, whose network and scene are used again.

    Attributes:
        experiment: the running experiment.
        plan: the parts from which it was opened.
        parameters: the parameters of its brain script and transfer functions, with their values.
        brain, world: the two engines.
        loop: the loop that steps them.
        on_step: called after every step, when events have happened and criteria are decided.
        on_close: called before the engines are released.
        on_change: called with the added and removed functions when transfer functions have changed.
        on_activate: called with name and state when a transfer function was activated or deactivated.
        on_reset: called with the part when a part of the run was reset alone.
        found: the findings before the run, or those of the snapshot from which it continues.
        reporters: return further findings about the run, such as those of a recorder.

    Raises:
        BackendError: a backend is missing, broken or does not open.
        InvalidExperimentError: the experiment is wrong; it carries all findings.
    """

    error: BaseException | None
    """The error that ended the run, if any."""
    reporters: list[Reporter]

    def __init__(
        self,
        experiment: Experiment,
        progress: ProgressCallback = no_progress,
        *,
        revise: Callable[[Plan], Plan] | None = None,
        build: Build | None = None,
        beside: Run | None = None,
    ) -> None:
        if not isinstance(experiment, Experiment):
            raise ExperimentError(
                f"a Run takes an experiment, as load_experiment('...') returns it, not {experiment!r:.60}"
            )
        if beside is not None and isinstance(experiment.maker, Participant):
            raise CapabilityError("an experiment with state machines has only one run at a time")
        with CollectorPaused():
            plan = (
                prepare(experiment, progress, build) if beside is None else beside.plan.with_fresh_functions()
            )
        if revise is not None:
            plan = revise(plan)
        self.experiment = experiment
        self.plan: Plan = plan
        self.on_step: list[Observer] = []
        self.on_close: list[Callable[[], None]] = []
        self.on_change: list[Callable[[Sequence[TransferFunction | Path], Sequence[str]], None]] = []
        self.on_activate: list[Callable[[str, bool], None]] = []
        self.on_reset: list[Callable[[str], None]] = []
        self.parameters = plan.parameters
        self._build = build
        self._planned = plan.warnings
        with CollectorPaused(), ExitStack() as opened:
            progress(f"opening the world ({experiment.world.backend})")
            self.world: World = opened.enter_context(
                open_side(experiment.world, plan.world, plan.scene, self.seed)
                if beside is None
                else open_beside(beside.world, experiment.world, plan.world, self.seed)
            )
            progress(f"opening the brain ({experiment.brain.backend})")
            self.brain: Brain = opened.enter_context(
                open_side(experiment.brain, plan.brain, plan.network, self.seed)
            )
            collector = Collector(experiment.source)
            declare_own(experiment, self.world, collector)
            declare_missing_topics(experiment, self.world, plan.functions)
            self._watch = Watch(experiment, self.world, collector)
            self._interventions = Interventions(experiment, self.brain, self._watch.events)
            collector.raise_errors()
            robots = experiment.world.robots
            falls = FallWatch(plan.scene, robots, self.world.capabilities)
            self._observation = Observation(self._watch, falls, robots)
            unheard = UnheardCommands(self.world, experiment.topics, lambda: self.loop.functions)
            self._silent = SilentTopics(experiment, self.world, lambda: self.loop.functions)
            self.reporters = [unheard.findings, self._silent.findings, falls.findings]
            self.reporters += [self._at_the_end, self._too_fast]
            self.loop: ClosedLoop = opened.enter_context(self._close_loop(plan))
            watch_outside(self.loop, self.reporters, self.on_close)
            neurons = np.arange(self.brain.network.size)
            self._counter = self.brain.add_sink(SpikeCounter(), neurons, name="result")
            self._begin()
            if isinstance(experiment.maker, Participant):
                experiment.maker.begin(self)
            self._close = opened.pop_all().close

    def _close_loop(self, plan: Plan) -> ClosedLoop:
        limit_ns = self.experiment.function_time_limit
        loop = ClosedLoop(
            self.brain,
            self.world,
            plan.functions,
            period_ns=self.experiment.timestep,
            tf_time=self.experiment.tf_time,
            on_error=self.experiment.on_error,
            function_time_limit_s=None if limit_ns is None else seconds(limit_ns),
            pacing=pacing_of(self.experiment.pace),
        )
        loop.hooks.before_step.append(self._observation.look)
        loop.hooks.after_step.extend((self._observation.look, self._after_step))
        loop.hooks.after_reset.append(self._after_reset)
        return loop

    @property
    def problems(self) -> tuple[Finding, ...]:
        """The findings about the run so far, by weight, then by place."""
        engines = (*self.world.warnings, *self.brain.warnings)
        ends = ends_of(self.loop.failures, self.error, self.now_s)
        found = not_failed(self.found, self.loop.failures)
        problems = problems_of(found, engines, ends, self.reporters)
        return tuple(without(problems, self.experiment.checks.ignore))

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self.experiment.seed

    @property
    def now_s(self) -> float:
        """The simulated time reached, s."""
        return seconds(self.loop.now_ns)

    # -- running

    def publish(self, topic: str, value: Any) -> None:
        """Publish a message before the next step; any thread may.

        Args:
            topic: its name or an alias.
            value: a message, or a value for :func:`~nrp_core.experiment.events.values.to_message`:
                ``"red"``, ``0.5``, ``{"linear": {"x": 1}}``.

        Raises:
            TopicError: the topic does not exist, cannot be published on, or cannot carry the message.
        """
        info = self.world.advertise(topic).topic
        self.loop.publish(topic, to_message(info, value))

    def step(self) -> None:
        """Take one step."""
        self.run_until_ns(self.loop.now_ns + self.experiment.timestep)

    def run_until(self, t_s: float) -> None:
        """Run to a time.

        Raises:
            TimestepError: it is not a whole number of steps away, or has passed.
            SimulationError: an engine or a transfer function failed.
        """
        self.run_until_ns(end_ns(t_s, self.loop.now_ns, self.experiment.duration))

    def run_until_ns(self, until_ns: int) -> None:
        """Run to a time in ns; as :meth:`run_until`."""
        began = work.now_ns()
        if isinstance(self.error, KeyboardInterrupt):
            self.error = None  # the run continues
        try:
            self.loop.run_until(until_ns)
        except TimestepError:
            raise  # nothing has run
        except BaseException as error:
            self.error = error
            raise
        finally:
            self._wall_ns += work.now_ns() - began

    def run(self, until_s: float | None = None) -> None:
        """Run to the end.

        Args:
            until_s: end time, s; by default the experiment's duration.
        """
        self.run_until(seconds(self.experiment.duration) if until_s is None else until_s)

    @checks_arguments()
    def change(self, add: Added = (), remove: Iterable[str] | str = ()) -> None:
        """Add, replace and remove transfer functions before the next step, or change nothing; any thread may.

        Args:
            add: functions, or files with functions, or one; each replaces the function of the same name.
            remove: names of functions to remove, or one name.

        Raises:
            ExperimentError: a file or a function is wrong, or a name does not exist.
        """
        given: Iterable[Any] = (add,) if isinstance(add, TransferFunction | Path | str) else add
        added = tuple(each if isinstance(each, TransferFunction) else path_of(each) for each in given)
        names = (remove,) if isinstance(remove, str) else tuple(remove)
        loaded = ([each] if isinstance(each, TransferFunction) else self._load(each) for each in added)
        functions = [function for some in loaded for function in some]

        def make() -> None:
            self._silent.declare(functions)
            self.loop.change(functions, names)
            for observer in self.on_change:
                observer(added, names)

        self.loop.between_steps(make)

    def _load(self, path: Path) -> list[TransferFunction]:
        return load_function_file(path, self.experiment.function_parameters)

    @checks_arguments("active")
    def activate(self, name: str, active: bool = True) -> None:
        """Activate or deactivate a transfer function from the next step on; any thread may call this.

        Raises:
            ExperimentError: there is no function of this name.
        """

        def make() -> None:
            self.loop.activate(name, active)
            for observer in self.on_activate:
                observer(name, active)

        self.loop.between_steps(make)

    def reset(self, part: str) -> None:
        """Reset one part before the next step while time goes on; any thread may.

        Args:
            part: ``brain``: the network, see :meth:`.Simulation.reset`; ``robot``: the robots return to their
                initial poses, at rest; ``world``: all other models do, in their initial colours.

        Raises:
            ExperimentError: there is no such part.
            CapabilityError: the engine cannot move bodies.
        """
        check_part(part)

        def make() -> None:
            reset_part(part, self.brain, self.world, self.experiment.world.robots)
            if part == "brain":
                self._interventions.renew(self._watch.events.times)
            else:
                self._watch.where.refresh()
            for observer in self.on_reset:
                observer(part)

        self.loop.between_steps(make)

    # -- at each step

    def _begin(self) -> None:
        self.found = self._planned
        self.error, self._wall_ns = None, 0

    def _after_step(self, loop: ClosedLoop) -> None:
        for observer in self.on_step:
            observer(self)

    def _after_reset(self, loop: ClosedLoop) -> None:
        self._observation.reset()
        self._begin()

    # -- going back

    def snapshot(self) -> bytes:
        """Return the complete state of the run between two steps.

        Raises:
            CapabilityError: an engine, another participant such as a state machine, or a variable of a
                transfer function cannot be saved.
        """
        maker = self.experiment.maker
        if isinstance(maker, Participant) and not maker.can_be_saved:
            raise CapabilityError("the state machines of an experiment cannot be saved")
        own = (*self._observation.save(), self.problems)
        sides = self.brain.snapshot(), self.world.snapshot()
        try:
            return pickle.dumps((sides, self.loop.save(), own))
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            raise CapabilityError(
                f"a variable of a transfer function has a value that cannot be saved: {error}"
            ) from error

    def restore(self, snapshot: bytes) -> None:
        """Return to a snapshot, also to one of another run of the same experiment.

        It is a Python pickle: like the experiment itself, it can run any code.

        Raises:
            SnapshotError: it is of another experiment, or from another version.
        """
        try:
            (brain, world), loop, own = pickle.loads(snapshot)
            self.brain.restore(brain)
            self.world.restore(world)
            self.loop.restore(loop)
            self._observation.restore(own[:3])
            self.found = tuple(own[3]) if own[3:] else self.found  # no findings in version 0.1
        except NrpError:
            raise
        except Exception as error:  # invalid bytes may raise anything
            raise SnapshotError(f"the snapshot cannot be read: {type(error).__name__}: {error}") from error

    def start_over(self, seed: int) -> None:
        """Return to time 0 with another seed, as a new run with that seed; the engines stay open.

        Raises:
            CapabilityError: the seed changes the network, or takes part in what cannot start over, such as a
                state machine. A new run is needed; this one is as it was.
        """
        if isinstance(self.experiment.maker, Participant):
            raise CapabilityError("the state machines of an experiment cannot start over")
        experiment = self.experiment.with_seed(seed)
        if load_network_only(experiment, self._build).digest != self.brain.network.digest:
            raise CapabilityError(f"seed {seed} gives another network")
        self.loop.reset(seed=seed)
        self.continue_as(experiment)  # its functions are new, for files may keep values of their own

    def continue_as(self, experiment: Experiment) -> None:
        """Continue with the transfer functions of another experiment that is otherwise equal.

        Raises:
            ExperimentError: one of them is wrong; then nothing is changed.
        """
        collector = Collector(experiment.source)
        functions = tuple(maker_of(experiment).functions(experiment, collector))
        collector.raise_errors()
        declare_missing_topics(experiment, self.world, functions)
        names = {function.name for function in functions}
        self.loop.change(functions, [one.name for one in self.loop.functions if one.name not in names])
        self.experiment = experiment

    # -- the end

    @property
    def spikes(self) -> dict[str, int]:
        """The number of spikes so far, by population and view."""
        return dict(self._counter.of(self.brain.network))

    @property
    def _is_over(self) -> bool:
        return self.loop.now_ns >= self.experiment.duration and self.error is None

    def _too_fast(self) -> Iterator[Finding]:
        return too_fast(self.experiment, self.brain.network, self.spikes, self.now_s)

    def _at_the_end(self) -> Iterator[Finding]:
        times, loop = self._watch.events.times, self.loop
        return at_the_end(
            self.experiment, times, loop.now_ns, loop.functions, self.found, is_over=self._is_over
        )

    def result(self) -> Result:
        """Return the result so far."""
        events = self._watch.events
        wall_s = seconds(self._wall_ns)
        outcomes = self._watch.outcomes(self.loop.now_ns if self._is_over else None)
        problems, state = self.problems, state_of(self.error)
        complete = is_complete(problems)
        return Result(
            experiment=self.experiment.name,
            brain=self.experiment.brain.backend,
            world=self.experiment.world.backend,
            seed=self.brain.seed,
            sim_time_s=self.now_s,
            wall_time_s=wall_s,
            real_time_factor=self.now_s / wall_s if wall_s else 0.0,
            steps=self.loop.steps,
            duration_s=seconds(self.experiment.duration),
            state=state,
            complete=complete,
            passed=passed_of(state, complete, (outcome.passed for outcome in outcomes.values())),
            problems=list(problems),
            error=None if self.error is None else str(self.error) or "interrupted",
            criteria=outcomes,
            time_share=self.loop.account.shares(),
            final_pose={name: pose_data(pose) for name, pose in self._observation.poses().items()},
            trajectory_digest=self._observation.digest.hexdigest(),
            spikes=self.spikes,
            activity=self._counter.activity(self.brain.network),
            events={
                name: seconds(events.times[name]) if name in events.times else None for name in events.names
            },
            failures=[failure_data(failure) for failure in self.loop.failures],
        )

    def outcomes(self) -> dict[str, Verdict]:
        """Return what came of each criterion so far."""
        return self._watch.outcomes()

    def passed(self) -> dict[str, bool | None]:
        """Return whether each criterion is met so far; None: it is not decided."""
        return self._watch.passed()

    @checks_arguments()
    def write_csv(self, folder: Path | None = None) -> list[Path]:
        """Write the rows of CSV recorders so far, and return the files.

        Args:
            folder: the folder; by default the experiment's ``csv_folder``.

        Raises:
            SimulationError: a file cannot be written.
        """
        try:
            return write_csv(self.loop.functions, folder or self.experiment.csv_folder)
        except OSError as error:
            message = f"the CSV records cannot be written: {error.strerror or error}"
            raise SimulationError(message, t_ns=self.loop.now_ns) from error

    def close(self) -> None:
        """Release both engines; the result remains available."""
        while self.on_close:
            self.on_close.pop()()
        self._close()
