"""Additions of an experiment to its world: topics and aliases, events and criteria."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

from nrp_core.cle.wiring import declare_unserved
from nrp_core.dsl.functions import TransferFunction
from nrp_core.experiment.events.criteria import Judge, Verdict, judge_of
from nrp_core.experiment.events.events import Action, AllOf, Events, action_of, trigger
from nrp_core.experiment.events.lanes import Column, LaneKind
from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Level, has_errors
from nrp_core.messages.base import type_name
from nrp_core.messages.std_msgs import Float64
from nrp_core.observables.moments import BetweenSteps
from nrp_core.observables.observable import Observable, Surroundings, observable_of, topic_of
from nrp_core.observables.positions import GroundPositions
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World


def declare_own(experiment: Experiment, world: World, collector: Collector) -> bool:
    """Add the topics and aliases of an experiment to a world; mistakes go to the collector.

    Returns:
        Whether no mistake prevents a run.
    """
    findings_before = len(collector.findings)
    for topic in experiment.world.commands:
        with collector.during(Code.NRP212, "world", "commands", topic):
            world.advertise(topic)
    for i, topic in enumerate(experiment.recording.topics):
        with collector.during(Code.NRP212, "recording", "topics", i):
            world.unsubscribe(world.subscribe(topic))
    for name, kind in experiment.topics.items():
        with collector.during(Code.NRP212, "topics", name):
            world.declare(name, kind)
    for name in experiment.observables:
        with collector.during(Code.NRP212, "observables", name):
            world.declare(topic_of(name), Float64)
    for alias, topic in experiment.aliases.items():
        with collector.during(Code.NRP212, "aliases", alias, level=_severity(experiment)):
            world.add_alias(alias, topic)
    return not has_errors(collector.findings[findings_before:])


def _severity(experiment: Experiment) -> Level:
    """Return the level of a finding about a missing topic."""
    return Level.ERROR if experiment.strict else Level.WARNING


def declare_missing_topics(
    experiment: Experiment, world: World, functions: Sequence[TransferFunction]
) -> list[str]:
    """Add the topics that the functions of an experiment expect to a world.

    Returns:
        The missing topics that were added because the experiment is not strict.
    """
    maker_of(experiment).declare_missing_topics(world, functions)
    if experiment.strict:
        return []
    declared = declare_unserved(functions, world)
    published = {topic.name for function in functions for topic in function.published}
    return [topic for topic in declared if topic not in published]


def warn_of_missing_topics(
    collector: Collector, experiment: Experiment, world: World, functions: Sequence[TransferFunction]
) -> None:
    """Add the topics that functions expect to a world, with a warning for each without a publisher."""
    served, known = dict(world.topics), len(world.warnings)
    for topic in declare_missing_topics(experiment, world, functions):
        message = silent_topic(topic, served)
        collector.add(Code.NRP212, message, "transfer_functions", level=Level.WARNING, subject=topic)
    collector.findings += world.warnings[known:]


def silent_topic(topic: str, served: Mapping[str, TopicInfo]) -> str:
    """Return a sentence about a topic that the world does not have, with one that ends in the same name."""
    ending = f"/{topic.rpartition('/')[2]}"
    others = [info for name, info in served.items() if name.endswith(ending)]
    other = f"; '{others[0].name}' carries {type_name(others[0].type)}" if others else ""
    return f"the world has no topic '{topic}': it is silent unless a function publishes on it{other}"


class Watch:
    """Executes the events of an experiment and evaluates its criteria and observables during a run.

    Args:
        experiment: the experiment with the events, criteria and observables.
        world: the world with the topics and aliases of the experiment.
        collector: receives mistakes; the rest works.

    Attributes:
        where: the positions of models.
        around: the data that observables can read; the brain is added when it is opened.
        events: the events.
        observables: the observables of the experiment, by name.
    """

    def __init__(self, experiment: Experiment, world: World, collector: Collector) -> None:
        self.where = GroundPositions(world, experiment.timestep)
        self._between = BetweenSteps(world, self.where)
        self.around = Surroundings(world, self.where, experiment.observables)
        self._world, self.events = world, Events()
        for name, event in experiment.events.items():
            actions: list[Action] = []
            for i, publish in enumerate(event.publish):
                place = experiment.place("events", name, "publish", i) if experiment.strict else None
                with collector.during(Code.NRP213, "events", name, "publish", i, level=_severity(experiment)):
                    actions.append(action_of(publish, world, place))
            with collector.during(Code.NRP213, "events", name, "when"):
                self.events.add(name, trigger(event, self.around), actions)
        self._judges: dict[str, Judge] = {}
        for name, criterion in experiment.criteria.items():
            kinds = ("near", "stays_within", "topic_stays", "observable")
            with collector.during(Code.NRP213, "criteria", name, *kinds):
                self._judges[name] = judge_of(criterion, self.around)
        self.observables: dict[str, Observable] = {}
        for name in experiment.observables:
            with collector.during(Code.NRP213, "observables", name):
                self.observables[name] = observable_of(name, self.around)
                world.set_unit(topic_of(name), self.observables[name].unit)
        self._published = {name: world.advertise(topic_of(name)) for name in self.observables}
        self._values: dict[str, Any] = {}
        self._lent: tuple[Sequence[Column], int] | None = None
        self._receiving: list[AllOf | Judge] = []
        self._unspoilt = self._states()

    # -- in many copies at once; see Lane

    def lane_kinds(self) -> tuple[LaneKind | None, ...]:
        """Return how arrays can evaluate each event and criterion; None: they cannot."""
        moving = self.where.moving
        judges = [judge.lane_kind(moving) for judge in self._judges.values()]
        return (*self.events.lane_kinds(moving), *judges)

    def lend(self, columns: Sequence[Column], row: int, now_ns: int) -> None:
        """Write the present states of events and criteria into a row of arrays, which count on from there."""
        judges = [(judge.lane(self.events.times), judge.sentence) for judge in self._judges.values()]
        for column, (lane, sentence) in zip(columns, (*self.events.lanes(now_ns), *judges), strict=True):
            column.enter(row, lane, sentence)
        self._lent = columns[len(columns) - len(judges) :], row
        opened = [
            judge for judge, (lane, _) in zip(self._judges.values(), judges, strict=True) if lane.is_open
        ]
        watched: tuple[AllOf | Judge, ...] = (*self.events.waiting, *self._judges.values())
        self._receiving = [one for one in watched if one.hears and one not in opened]

    def settle(self) -> None:
        """Set the states of criteria to what the arrays have counted."""
        if self._lent is not None:
            columns, row = self._lent
            for column, judge in zip(columns, self._judges.values(), strict=True):
                if state := column.state(row):
                    judge.settle(*state)

    @property
    def is_lent(self) -> bool:
        """Whether arrays have the present states."""
        return self._lent is not None

    @property
    def has_looked(self) -> bool:
        """Whether it has looked at bodies between the last two steps."""
        return self._between.has_looked

    def take_back(self) -> None:
        """Continue without arrays."""
        self.settle()
        self._lent = None

    def pass_quietly(self, now_ns: int) -> None:
        """Process a time at which arrays have evaluated all events and criteria."""
        self._between.rest()
        for each in self._receiving:
            each.news()
        if self.observables:
            self._measure(now_ns)

    # -- alone

    def reset(self) -> None:
        """Reset to time 0."""
        self._lent = None
        self.where.refresh()
        self._between.plan(0, ())
        self.events.reset()
        self._restore_states(self._unspoilt)

    def save(self) -> Any:
        """Return the past events and the state of the criteria and observables."""
        self.settle()
        return self.events.save(), self._states()

    def _states(self) -> dict[str, dict[str, Any]]:
        return {
            "criteria": {name: judge.save() for name, judge in self._judges.items()},
            "observables": {name: one.save() for name, one in self.observables.items()},
            "values": dict(self._values),
        }

    def _restore_states(self, states: Mapping[str, Mapping[str, Any]]) -> None:
        self._values = dict(states["values"])
        kept: dict[str, Mapping[str, Any]] = {"criteria": self._judges, "observables": self.observables}
        for kind, things in kept.items():
            for name, thing in things.items():
                if name in states[kind]:
                    thing.restore(states[kind][name])

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, for the same experiment, in a world that was restored."""
        self._lent = None
        self.where.refresh()
        events, states = saved
        self.events.restore(events)
        self._restore_states(states)
        self._between.plan(self._world.now_ns, (*self.events.waiting, *self._judges.values()))

    def evaluate(self, now_ns: int) -> None:
        """Process the time that the world has reached; called once for each time."""
        if self._lent is not None:
            self.take_back()
        self.where.refresh()
        judges, times = self._judges.values(), self.events.times
        for moment_ns, changed in self._between.moments(now_ns, (*self.events.waiting, *judges)):
            self.events.fire_due(moment_ns, changed)
            for judge in judges:
                if judge in changed:
                    judge.evaluate(moment_ns, times, between=True)
        self.events.fire_due(now_ns)
        for judge in judges:
            judge.evaluate(now_ns, times)
        if self.observables:
            self._measure(now_ns)
        self._between.plan(now_ns, (*self.events.waiting, *judges))

    def _measure(self, now_ns: int) -> None:
        """Read the observables of the experiment, and publish those that are numbers."""
        self._values = {name: one.value(now_ns) for name, one in self.observables.items()}
        for name, value in self._values.items():
            if isinstance(value, Real):
                self._published[name].publish(Float64(float(value)))

    @property
    def values(self) -> dict[str, Any]:
        """The value of each observable of the experiment at the last step; None: it has none yet."""
        return dict(self._values)

    def outcomes(self, end_ns: int | None = None) -> dict[str, Verdict]:
        """Return the outcome of each criterion so far.

        Args:
            end_ns: the time reached, if the run is over: the criteria are decided as they stand then. A run
                that continues is not affected.
        """
        self.settle()
        return {name: judge.outcome_at(end_ns) for name, judge in self._judges.items()}

    def passed(self) -> dict[str, bool | None]:
        """Return whether each criterion is met so far; None: it is not decided."""
        return {name: judge.passed for name, judge in self._judges.items()}
