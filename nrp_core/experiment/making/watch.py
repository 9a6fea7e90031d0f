"""Additions of an experiment to its world: topics and aliases, events and criteria."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from nrp_core.cle.wiring import declare_unserved
from nrp_core.dsl.functions import TransferFunction
from nrp_core.experiment.events.between_steps import BetweenSteps
from nrp_core.experiment.events.criteria import Judge, Verdict, judge_of
from nrp_core.experiment.events.events import Action, Events, action_of, trigger
from nrp_core.experiment.events.ground_positions import GroundPositions
from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Level, has_errors
from nrp_core.messages.base import type_name
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World


def declare_own(experiment: Experiment, world: World, collector: Collector) -> bool:
    """Add the topics and aliases of an experiment to a world; mistakes go to the collector.

    Returns:
        Whether there are no mistakes that prevent a run.
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
    """Add the topics that functions expect to a world, with a warning for each that nothing publishes."""
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
    """Executes the events of an experiment and evaluates its criteria during a run.

    Args:
        experiment: the experiment with the events and criteria.
        world: the world with the topics and aliases of the experiment.
        collector: receives mistakes; the rest works.
    """

    def __init__(self, experiment: Experiment, world: World, collector: Collector) -> None:
        self.where = GroundPositions(world, experiment.timestep)
        self._between = BetweenSteps(world, self.where)
        self._world, self.events = world, Events()
        for name, event in experiment.events.items():
            actions: list[Action] = []
            for i, publish in enumerate(event.publish):
                with collector.during(Code.NRP213, "events", name, "publish", i, level=_severity(experiment)):
                    actions.append(action_of(publish, world))
            with collector.during(Code.NRP213, "events", name, "when"):
                self.events.add(name, trigger(event, world, self.where), actions)
        self._judges: dict[str, Judge] = {}
        for name, criterion in experiment.criteria.items():
            with collector.during(Code.NRP213, "criteria", name, "near", "stays_within", "topic_stays"):
                self._judges[name] = judge_of(criterion, world)
        self._unspoilt = {name: judge.save() for name, judge in self._judges.items()}

    def reset(self) -> None:
        """Reset to time 0."""
        self.where.refresh()
        self._between.plan(0, ())
        self.events.reset()
        for name, judge in self._judges.items():
            judge.restore(self._unspoilt[name])

    def save(self) -> Any:
        """Return the past events and the state of the criteria."""
        return dict(self.events.times), {name: judge.save() for name, judge in self._judges.items()}

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, for the same experiment, in a world that was restored."""
        self.where.refresh()
        times, judges = saved
        self.events.restore(times)
        for name, judge in self._judges.items():
            if name in judges:
                judge.restore(judges[name])
        self._between.plan(self._world.now_ns, (*self.events.waiting, *self._judges.values()))

    def evaluate(self, now_ns: int) -> None:
        """Process the time that the world has reached; called once for each time."""
        self.where.refresh()
        judges = self._judges.values()
        for moment_ns, changed in self._between.moments(now_ns, (*self.events.waiting, *judges)):
            self.events.fire_due(moment_ns, changed)
            for judge in judges:
                if judge in changed:
                    judge.evaluate(moment_ns, self.events.times, self.where, between=True)
        self.events.fire_due(now_ns)
        for judge in judges:
            judge.evaluate(now_ns, self.events.times, self.where)
        self._between.plan(now_ns, (*self.events.waiting, *judges))

    def outcomes(self, end_ns: int | None = None) -> dict[str, Verdict]:
        """Return the outcome of each criterion so far.

        Args:
            end_ns: the time reached, if the run is over: the criteria are decided as they stand then. A run
                that continues is not affected.
        """
        return {name: judge.outcome_at(end_ns) for name, judge in self._judges.items()}

    def passed(self) -> dict[str, bool | None]:
        """Return whether each criterion is met so far; None: it is not decided."""
        return {name: judge.passed for name, judge in self._judges.items()}
