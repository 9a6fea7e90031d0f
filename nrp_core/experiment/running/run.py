"""Run an experiment: open its engines, step the closed loop, evaluate it, and return the result.

::

    with Run(load_experiment("braitenberg_husky", ["seed=3"])) as simulation:
        simulation.run_until(5.0)
        simulation.publish("/screens/left/color", "red")
        simulation.run()
        print(simulation.result().passed)
"""

from __future__ import annotations

import logging
import pickle
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy.typing as npt

from nrp_core._support.checked_arguments import checks_arguments, is_number
from nrp_core._support.closing import Closing
from nrp_core._support.collector import CollectorPaused
from nrp_core._support.overview import Overview, Row
from nrp_core._support.stopwatch import work
from nrp_core.brain.interface import Brain
from nrp_core.cle import ClosedLoop, pacing_of
from nrp_core.clock import from_seconds, seconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import csv_texts, write_csv
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    NetworkError,
    NrpError,
    SimulationError,
    SnapshotError,
    TimestepError,
    did_you_mean,
)
from nrp_core.experiment.events.criteria import Verdict
from nrp_core.experiment.events.events import to_message
from nrp_core.experiment.making.interventions import Interventions
from nrp_core.experiment.making.maker import load_function_file, maker_of
from nrp_core.experiment.making.plan import Plan, ProgressCallback, no_progress
from nrp_core.experiment.making.prepare import load_network_only, open_engine, open_world_like, prepare
from nrp_core.experiment.making.watch import declare_missing_topics, declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Build, Experiment
from nrp_core.experiment.running.lost_messages import CommandsWithoutReceiver, LostMessages, SilentTopics
from nrp_core.experiment.running.many_observations import ManyObservations
from nrp_core.experiment.running.observation import FallWatch, Observation
from nrp_core.experiment.running.observers import Participant, RunObserver, StepObserver
from nrp_core.experiment.running.picture import Picture, image_of
from nrp_core.experiment.running.problems import (
    Reporter,
    at_the_end,
    ends_of,
    not_failed,
    problems_of,
    too_fast,
)
from nrp_core.experiment.running.result import Result, failure_data, passed_of, pose_data, state_of
from nrp_core.findings import Finding
from nrp_core.findings.problems import is_complete, without
from nrp_core.findings.refusals import SCENE_CHANGES
from nrp_core.messages.base import type_name
from nrp_core.network.changes import one_for_each
from nrp_core.paths import check_free, path_of
from nrp_core.world.world import World

Added: TypeAlias = Iterable[TransferFunction | Path | str] | TransferFunction | Path | str
"""Functions, or files of functions."""

PARTS: Final = ("brain", "robot", "world")
"""The parts of a run that can be reset alone."""
_LONGEST_S: Final = 1e8
"""Three years; a time in ns is larger."""
_OFTEN: Final = 10
"""Who runs an experiment for so many times its duration probably counts in ms."""
_logger = logging.getLogger(__name__)


class Run(Overview, Closing):
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
        observers: called at each step, change, reset of a part, and at the end; see :meth:`on_step`.
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
        self.observers: list[RunObserver[Any]] = []
        self.parameters = plan.parameters
        self._build = build
        self._planned = plan.warnings
        self._csv_files: set[Path] = set()
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
            falls = (
                FallWatch(plan.scene, experiment.world.robots, self.world.capabilities)
                if beside is None
                else beside._observation.falls.another()
            )
            self._observation: Observation = Observation(experiment, falls, self.world, collector)
            self._events = self._observation.watch.events
            self._interventions = Interventions(experiment, self.brain, self._events)
            collector.raise_errors()
            self.loop: ClosedLoop = opened.enter_context(self._close_loop(plan))
            self._observation.count_spikes(self.brain)
            self._report_problems()
            self._begin()
            if isinstance(experiment.maker, Participant):
                experiment.maker.begin(self)
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
        loop.hooks.together.append((ManyObservations, self._observation))
        loop.hooks.after_step.extend((self._observation.evaluate, self._after_step))
        loop.hooks.after_reset.append(self._after_reset)
        return loop

    def _begin(self) -> None:
        self.found = self._planned
        self.error, self._wall_ns = None, 0

    def _after_step(self, loop: ClosedLoop) -> None:
        for observer in self.observers:
            observer.after_step(self)

    def _after_reset(self, loop: ClosedLoop) -> None:
        self._observation.reset()
        self._begin()

    def _report_problems(self) -> None:
        """Register the observers that report findings during the run."""
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

    # -- the state

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

    # -- running

    def on_step(self, function: Callable[[Run], object]) -> RunObserver[Run]:
        """Call a function with the run after every step, when events have happened and criteria are decided.

        Returns:
            The observer; remove it from :attr:`observers` to end the calls.
        """
        observer = StepObserver(function)
        self.observers.append(observer)
        return observer

    def publish(self, topic: str, value: Any) -> None:
        """Publish a message before the next step; any thread may.

        Args:
            topic: its name or an alias.
            value: a message, or a value for :func:`~nrp_core.experiment.events.events.to_message`:
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
        self.run_until_ns(_end_ns(t_s, self.loop.now_ns, self.experiment.duration))

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

    def note_step(self, wall_ns: int, error: Exception | None) -> None:
        """Note a step that its loop has taken together with those of other runs.

        Args:
            wall_ns: the wall time of its share, ns.
            error: the error that ended the run; None if it can go on.
        """
        self._wall_ns += wall_ns
        self.error = error

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
            for observer in self.observers:
                observer.functions_changed(self, added, names)

        self.loop.between_steps(make)

    def _load(self, path: Path) -> list[TransferFunction]:
        return load_function_file(path, self.experiment.function_parameters)

    @checks_arguments("active")
    def activate(self, name: str, active: bool = True) -> None:
        """Activate or deactivate a transfer function from the next step on; any thread may call this.

        Raises:
            ExperimentError: no function has this name.
        """

        def make() -> None:
            self.loop.activate(name, active)
            for observer in self.observers:
                observer.function_activated(self, name, active)

        self.loop.between_steps(make)

    def set_parameters(
        self, population: str, values: Mapping[str, float], cells: Iterable[int] | None = None
    ) -> None:
        """Change parameters of cells before the next step; any thread may.

        Recordings keep the change, unlike one by :meth:`.Brain.set_parameters`. A reset reverts it.

        Args:
            population: the label of their population.
            values: new values by PyNN name, in PyNN's units.
            cells: their indices within the population; by default all.

        Raises:
            CapabilityError: the brain cannot change them while it runs.
            NetworkError: the population, cell or parameter does not exist, or a value is impossible.
        """
        ids = self.brain.network.ids_of(population)
        chosen = range(len(ids)) if cells is None else tuple(cells)
        if not all(0 <= cell < len(ids) for cell in chosen):
            raise NetworkError(f"the cells of '{population}' are 0 to {len(ids) - 1}, not {list(chosen)}")

        def make() -> None:
            self.brain.set_parameters(ids[list(chosen)], values)
            for observer in self.observers:
                observer.parameters_changed(self, population, values, None if cells is None else chosen)

        self.loop.between_steps(make)

    def set_weights(self, projection: str, weights: npt.ArrayLike, *, relative: bool = False) -> None:
        """Change the weights of a projection before the next step; any thread may.

        Recordings keep the change, unlike one by :meth:`.Brain.set_weights`. A reset reverts it.

        Args:
            projection: its label.
            weights: in PyNN's units: one number for all synapses, or one for each.
            relative: whether they are factors of the present weights instead.

        Raises:
            CapabilityError: the brain cannot change them while it runs.
            NetworkError: the projection does not exist, or a weight is impossible.
        """

        def make() -> None:
            changed = weights
            if relative:
                present = self.brain.read_weights(projection)
                changed = present * one_for_each("weights", weights, len(present))
            self.brain.set_weights(projection, changed)
            for observer in self.observers:
                observer.weights_changed(self, projection, weights, relative)

        self.loop.between_steps(make)

    @checks_arguments("seed")
    def reset(self, what: str = "all", *, seed: int | None = None) -> None:
        """Return to time 0 between two calls, or reset one part before the next step, from any thread.

        Args:
            what: ``all``: the whole run; while time goes on ``brain``: the network, ``robot``: the robots
                return to their initial poses, at rest, ``world``: all other models do, in their initial
                colours. See :mod:`nrp_core.simulation`.
            seed: with ``all``: another seed, as of a new run; files of transfer functions are executed again.

        Raises:
            ExperimentError: the part does not exist, or it takes no seed.
            CapabilityError: the engine cannot move bodies, the seed changes the network, or bodies that the
                engine cannot exchange, or a participant such as a state machine cannot start over: a new run
                is needed, and this one does not change.
        """
        if what != "all":
            self._reset_part(what, seed)
        elif seed is None:
            self.loop.reset()
        else:
            self._start_over(seed)

    def _reset_part(self, part: str, seed: int | None) -> None:
        if part not in PARTS:
            names = ("all", *PARTS)
            raise ExperimentError(
                f"'{part}' cannot be reset, only one of {', '.join(names)}{did_you_mean(part, names)}"
            )
        if seed is not None:
            raise ExperimentError(f"only the whole run is reset with a seed, not '{part}'")

        def make() -> None:
            if part == "brain":
                self.brain.reset("state")
                self._interventions.reset(self._events.times)
            else:
                self._reset_models(part)
            for observer in self.observers:
                observer.part_reset(self, part)

        self.loop.between_steps(make)

    def _reset_models(self, part: str) -> None:
        robots, models = self.experiment.world.robots, self.world.scene.models
        names = [each.name for each in models if (each.name in robots) is (part == "robot")]
        self.world.reset("poses", names)
        if part == "world":
            self.world.reset("colors", names)
        self._observation.watch.where.refresh()

    def _start_over(self, seed: int) -> None:
        if isinstance(self.experiment.maker, Participant):
            raise CapabilityError("the state machines of an experiment cannot start over")
        experiment = self.experiment.with_seed(seed)
        if load_network_only(experiment, self._build).digest != self.brain.network.digest:
            raise CapabilityError(f"seed {seed} gives another network")
        if self.world.nominal.randomize and not self.world.capabilities.changes:
            raise CapabilityError(f"seed {seed} gives other bodies, and the world {SCENE_CHANGES}")
        self.loop.reset(seed=seed)
        self.continue_as(experiment)  # its functions are new, for files may keep values of their own

    # -- looking

    @property
    def spikes(self) -> dict[str, int]:
        """The number of spikes so far, by population and view."""
        return self._observation.spikes

    def result(self) -> Result:
        """Return the result so far."""
        experiment, loop, observation = self.experiment, self.loop, self._observation
        outcomes = observation.watch.outcomes(loop.now_ns if self.is_over else None)
        problems, state = self.problems, state_of(self.error)
        complete = is_complete(problems)
        return Result(
            experiment=experiment.name,
            brain=experiment.brain.backend,
            world=experiment.world.backend,
            seed=self.brain.seed,
            sim_time_s=self.now_s,
            wall_time_s=self.wall_s,
            real_time_factor=self.now_s / self.wall_s if self.wall_s else 0.0,
            steps=loop.steps,
            duration_s=seconds(experiment.duration),
            state=state,
            complete=complete,
            passed=passed_of(state, complete, (outcome.passed for outcome in outcomes.values())),
            problems=list(problems),
            error=None if self.error is None else str(self.error) or "interrupted",
            criteria=outcomes,
            time_share=loop.account.shares(),
            final_pose={name: pose_data(pose) for name, pose in observation.poses().items()},
            trajectory_digest=observation.digest.hexdigest(),
            spikes=observation.spikes,
            activity=observation.activity,
            events=self.events,
            failures=[failure_data(failure) for failure in loop.failures],
        )

    def outcomes(self) -> dict[str, Verdict]:
        """Return the outcome of each criterion so far."""
        return self._observation.watch.outcomes()

    @property
    def observables(self) -> dict[str, Any]:
        """The value of each observable of the experiment at the last step; None: it has none yet."""
        return self._observation.watch.values

    @property
    def events(self) -> dict[str, float | None]:
        """The times of events, s; None for those that have not happened."""
        times = self._events.times
        return {name: seconds(times[name]) if name in times else None for name in self._events.names}

    def passed(self) -> dict[str, bool | None]:
        """Return whether each criterion is met so far; None: it is not decided."""
        return self._observation.watch.passed()

    @checks_arguments()
    def write_csv(self, folder: Path | None = None, *, overwrite: bool = False) -> list[Path]:
        """Write the rows of CSV recorders so far, and return the files.

        Args:
            folder: the folder; by default the experiment's ``csv_folder``.
            overwrite: whether to replace existing files that this run has not written.

        Raises:
            ExperimentError: a file exists.
            SimulationError: a file cannot be written.
        """
        self.check_csv(folder, overwrite=overwrite)
        try:
            files = write_csv(self.loop.functions, folder or self.experiment.csv_folder)
        except OSError as error:
            message = f"the CSV records cannot be written: {error.strerror or error}"
            raise SimulationError(message, t_ns=self.loop.now_ns) from error
        self._csv_files.update(files)
        return files

    def check_csv(self, folder: Path | None = None, *, overwrite: bool = False) -> None:
        """Refuse files that :meth:`write_csv` would refuse, before the run.

        Raises:
            ExperimentError: a file exists.
        """
        for path in csv_texts(self.loop.functions, folder or self.experiment.csv_folder):
            check_free(path, overwrite=overwrite or path in self._csv_files)

    @checks_arguments()
    def show(self, of: Iterable[str] | str | None = None, *, width: int = 640, height: int = 480) -> Picture:
        """Return a picture of the run's present state, for notebooks; it does not change the run.

        Args:
            of: names of models in the middle of the picture, or one; by default the robots. With an empty
                list the whole scene is in it.
            width: the width of the image, pixels.
            height: its height, pixels.

        Raises:
            SceneError: the scene cannot be drawn, or the model does not exist.
        """
        names = (of,) if isinstance(of, str) else tuple(self._observation.poses() if of is None else of)
        cells = {name: len(self.brain.network.neurons(name)) for name in self.spikes}
        rates_hz = {
            name: count / cells[name] / self.now_s if self.now_s else 0.0
            for name, count in self.spikes.items()
        }
        title = f"{self.experiment.name} at {self.now_s:g} s"
        return Picture(image_of(self.world, width, height, names), title, rates_hz)

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

    def close(self) -> None:
        """Release both engines; the result remains available."""
        observers = [] if self._is_closed else self.observers[::-1]
        self._is_closed = True
        with self._opened:
            for observer in observers:
                observer.closing(self)


def _end_ns(t_s: float, now_ns: int, duration_ns: int) -> int:
    """Return the time to run to, and log a warning about one far beyond the experiment.

    Args:
        t_s: the requested time, s.
        now_ns: the time reached.
        duration_ns: the duration of the experiment.

    Raises:
        TimestepError: it is not a time, or has passed.
    """
    if not is_number(t_s) or not abs(t_s) <= _LONGEST_S:
        raise TimestepError(f"cannot run to {t_s!r}: a time is a number of seconds, below {_LONGEST_S:g}")
    until_ns = from_seconds(t_s)
    if until_ns < now_ns:
        raise TimestepError(f"cannot run to {t_s:g} s: the time is {seconds(now_ns):g} s")
    if until_ns - now_ns > _OFTEN * duration_ns:
        _logger.warning(
            "the run goes to %g s, and the duration of the experiment is %g s; times of a run are in s: "
            "write %g for %g ms",
            t_s, seconds(duration_ns), t_s / 1000.0, t_s,
        )  # fmt: skip
    return until_ns
