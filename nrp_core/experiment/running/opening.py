"""Open an experiment: its engines, the loop between them, its observation, and its findings and result."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.closing import Closing
from nrp_core._support.collector import CollectorPaused
from nrp_core._support.overview import Overview, Row
from nrp_core.brain.interface import Brain
from nrp_core.cle import ClosedLoop, pacing_of
from nrp_core.clock import seconds
from nrp_core.dsl.mappings import write_csv
from nrp_core.errors import CapabilityError, ExperimentError, SimulationError
from nrp_core.experiment.events.criteria import Verdict
from nrp_core.experiment.making.interventions import Interventions
from nrp_core.experiment.making.plan import Plan, ProgressCallback, no_progress
from nrp_core.experiment.making.prepare import open_engine, open_world_like, prepare
from nrp_core.experiment.making.watch import declare_missing_topics, declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Build, Experiment
from nrp_core.experiment.running.lost_messages import CommandsWithoutReceiver, LostMessages, SilentTopics
from nrp_core.experiment.running.observation import Observation
from nrp_core.experiment.running.observers import Participant, RunObserver
from nrp_core.experiment.running.problems import (
    Reporter,
    at_the_end,
    ends_of,
    not_failed,
    problems_of,
    too_fast,
)
from nrp_core.experiment.running.result import (
    Result,
    failure_data,
    passed_of,
    pose_data,
    state_of,
)
from nrp_core.findings import Finding
from nrp_core.findings.problems import is_complete, without
from nrp_core.messages.base import type_name
from nrp_core.world.world import World


class OpenExperiment(Overview, Closing):
    """An experiment with open engines: the part of a :class:`.Run` that opens, observes and reports."""

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
        beside: OpenExperiment | None = None,
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
        self.observers: list[RunObserver[Any]] = []
        self.parameters = plan.parameters
        self._build = build
        self._planned = plan.warnings
        with CollectorPaused(), ExitStack() as opened:
            progress(f"opening the world ({experiment.world.backend})")
            self.world: World = opened.enter_context(
                open_engine(experiment.world, plan.world, plan.scene, self.seed)
                if beside is None
                else open_world_like(beside.world, experiment.world, plan.world, self.seed)
            )
            progress(f"opening the brain ({experiment.brain.backend})")
            self.brain: Brain = opened.enter_context(
                open_engine(experiment.brain, plan.brain, plan.network, self.seed)
            )
            collector = Collector(experiment.source)
            declare_own(experiment, self.world, collector)
            declare_missing_topics(experiment, self.world, plan.functions)
            self._observation = Observation(experiment, plan.scene, self.world, collector)
            self._events = self._observation.watch.events
            self._interventions = Interventions(experiment, self.brain, self._events)
            collector.raise_errors()
            self.loop: ClosedLoop = opened.enter_context(self._close_loop(plan))
            self._observation.count_spikes(self.brain)
            self._report_problems()
            self._begin()
            self._join_participants()
            self._opened, self._is_closed = opened.pop_all(), False

    def _overview(self) -> tuple[str, Iterable[Row]]:
        end_s = seconds(self.experiment.duration)
        return f"of {self.experiment.name} at {self.now_s:g} s of {end_s:g} s", [
            ("topic", "type"),
            *((name, type_name(topic.type)) for name, topic in self.world.topics.items()),
        ]

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
        loop.hooks.before_step.append(self._observation.evaluate)
        loop.hooks.after_step.extend((self._observation.evaluate, self._after_step))
        loop.hooks.after_reset.append(self._after_reset)
        return loop

    def _report_problems(self) -> None:
        """Register what reports findings while the experiment runs."""
        undelivered = CommandsWithoutReceiver(self.world, self.experiment.topics, lambda: self.loop.functions)
        self._silent = SilentTopics(self.experiment, self.world, lambda: self.loop.functions)
        outside = LostMessages(self.loop)
        self.observers.append(outside)
        self.reporters = [undelivered.findings, self._silent.findings, self._observation.falls.findings]
        self.reporters += [self._progress_findings, outside.findings]

    def _progress_findings(self) -> Iterator[Finding]:
        experiment, loop = self.experiment, self.loop
        yield from at_the_end(
            experiment, self._events.times, loop.now_ns, loop.functions, self.found, is_over=self.is_over
        )
        yield from too_fast(experiment, self.brain.network, self.spikes, self.now_s)

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

    @property
    def wall_s(self) -> float:
        """The wall time that running took so far, s."""
        return seconds(self._wall_ns)

    @property
    def is_over(self) -> bool:
        """Whether the run has reached the end of the experiment without an error."""
        return self.loop.now_ns >= self.experiment.duration and self.error is None

    @abstractmethod
    def _join_participants(self) -> None:
        """Let other participants of the experiment begin, once everything is open."""

    # -- at each step

    def _begin(self) -> None:
        self.found = self._planned
        self.error, self._wall_ns = None, 0

    @abstractmethod
    def _after_step(self, loop: ClosedLoop) -> None:
        """Call the observers."""

    def _after_reset(self, loop: ClosedLoop) -> None:
        self._observation.reset()
        self._begin()

    # -- the end

    @property
    def spikes(self) -> dict[str, int]:
        """The number of spikes so far, by population and view."""
        return self._observation.spikes

    def result(self) -> Result:
        """Return the result so far."""
        return _result_of(self, self._observation)

    def outcomes(self) -> dict[str, Verdict]:
        """Return what came of each criterion so far."""
        return self._observation.watch.outcomes()

    def passed(self) -> dict[str, bool | None]:
        """Return whether each criterion is met so far; None: it is not decided."""
        return self._observation.watch.passed()

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


def _result_of(run: OpenExperiment, observation: Observation) -> Result:
    """Return the result of a run so far.

    Args:
        run: the run.
        observation: its observation.
    """
    experiment, loop, events = run.experiment, run.loop, observation.watch.events
    outcomes = observation.watch.outcomes(loop.now_ns if run.is_over else None)
    problems, state = run.problems, state_of(run.error)
    complete = is_complete(problems)
    return Result(
        experiment=experiment.name,
        brain=experiment.brain.backend,
        world=experiment.world.backend,
        seed=run.brain.seed,
        sim_time_s=run.now_s,
        wall_time_s=run.wall_s,
        real_time_factor=run.now_s / run.wall_s if run.wall_s else 0.0,
        steps=loop.steps,
        duration_s=seconds(experiment.duration),
        state=state,
        complete=complete,
        passed=passed_of(state, complete, (outcome.passed for outcome in outcomes.values())),
        problems=list(problems),
        error=None if run.error is None else str(run.error) or "interrupted",
        criteria=outcomes,
        time_share=loop.account.shares(),
        final_pose={name: pose_data(pose) for name, pose in observation.poses().items()},
        trajectory_digest=observation.digest.hexdigest(),
        spikes=observation.spikes,
        activity=observation.activity,
        events={name: seconds(events.times[name]) if name in events.times else None for name in events.names},
        failures=[failure_data(failure) for failure in loop.failures],
    )
