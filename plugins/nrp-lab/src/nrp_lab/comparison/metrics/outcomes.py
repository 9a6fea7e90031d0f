"""The finding of an experiment: whether its criteria are met, and when the awaited events happen."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from nrp_core.experiment.model.experiment import Experiment
from nrp_lab.comparison.metrics.base import Margin, ScalarMetric
from nrp_lab.comparison.signals import RunSignals


class _OfCriteria(ScalarMetric):
    """A number from 0 to 1 for each criterion."""

    margin = Margin(at_most=0.25)
    needs_recording = False

    def parts(self, experiment: Experiment) -> Collection[str]:
        return experiment.criteria.keys()


class CriteriaMet(_OfCriteria):
    """Whether each criterion is met; a failed run meets none."""

    name, title = "criteria", "Criteria met"
    is_finding = is_share = True

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        outcomes = run.result.get("criteria") or {}
        return {
            name: 0.0 if run.failed else None if one["passed"] is None else float(one["passed"])
            for name, one in outcomes.items()
        }


class CriterionDegree(_OfCriteria):
    """How nearly each criterion is met, from 0 to 1.

    For ``near`` it is the share of the way to the target, for others the share of the steps in which the
    condition held. A criterion whose evaluation never began has 0.
    """

    name, title = "degree", "Degree of a criterion"
    is_compared = False  # as are the outcomes and distances of criteria

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        outcomes = run.result.get("criteria") or {}
        return {name: one.get("degree") for name, one in outcomes.items()}


class TimeToEvent(ScalarMetric):
    """The time until a model comes near a target, and until a conditional event happens.

    The time of a criterion starts at the event that it follows. An event that coincides with a criterion is
    left out.
    """

    name, title, unit = "time_to_event", "Time to event", "s"
    is_finding = True
    needs_recording = False

    def parts(self, experiment: Experiment) -> Collection[str]:
        near = [name for name, criterion in experiment.criteria.items() if criterion.near]
        return [*near, *(name for name, event in experiment.events.items() if event.when)]

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        settings, outcomes = run.settings, run.result.get("criteria") or {}
        near = [
            name
            for name, criterion in (settings.get("criteria") or {}).items()
            if criterion.get("near") and name in outcomes
        ]
        met = {name: outcomes[name] for name in near if outcomes[name]["passed"]}
        decided = {one["decided_s"] for one in met.values()}
        happened = run.result.get("events") or {}
        waiting = {
            name: happened.get(name)
            for name, event in (settings.get("events") or {}).items()
            if event.get("when")
        }
        times = {name: met[name]["took_s"] if name in met else None for name in near}
        return times | {name: t_s for name, t_s in waiting.items() if t_s not in decided}

    def resolution(self, run: RunSignals) -> float:
        """One step of the loop: events are checked between steps."""
        return run.step_s


class CriterionDistance(ScalarMetric):
    """The decisive distance of each criterion that has one.

    It is the smallest distance to a target (``near``), or the largest from a centre (``stays_within``).
    """

    name, title, unit = "criterion_distance", "Distance of a criterion", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length
    needs_recording = False

    def parts(self, experiment: Experiment) -> Collection[str]:
        criteria = experiment.criteria.items()
        return [name for name, criterion in criteria if criterion.near or criterion.stays_within]

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        outcomes = run.result.get("criteria") or {}
        return {name: one["distance"] for name, one in outcomes.items() if one["limit"] is not None}
