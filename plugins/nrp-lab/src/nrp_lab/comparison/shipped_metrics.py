"""The metrics that ship: outcomes of criteria, trajectories of robots, spikes and devices."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from math import atan2, cos, pi, sin
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.experiment import Experiment
from nrp_core.observables import topic_of
from nrp_core.recording import Role, Series
from nrp_core.world import Pose
from nrp_lab.comparison.metric import (
    DistanceMetric,
    Margin,
    Metric,
    ScalarMetric,
    dtw_distance,
    filtered_trains,
)
from nrp_lab.comparison.signals import RunSignals


class _CriterionMetric(ScalarMetric):
    """A number from 0 to 1 for each criterion."""

    margin = Margin(at_most=0.25)
    needs_recording = False

    def parts(self, experiment: Experiment) -> Collection[str]:
        return experiment.criteria.keys()


class CriteriaMet(_CriterionMetric):
    """Whether each criterion is met; a failed run meets none."""

    name, title = "criteria", "Criteria met"
    is_finding = is_share = True

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        outcomes = run.result.get("criteria") or {}
        return {
            name: 0.0 if run.failed else None if one["passed"] is None else float(one["passed"])
            for name, one in outcomes.items()
        }


class CriterionDegree(_CriterionMetric):
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


class ObservableValues(ScalarMetric):
    """The smallest, largest, mean and last value of each observable of the experiment."""

    name, title = "observables", "Values of observables"
    is_compared = False  # each alone is, as their units differ

    def parts(self, experiment: Experiment) -> Collection[str]:
        return [f"{name}.{how}" for name in experiment.observables for how in _REDUCTIONS]

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        known = {name: run.held(one) for name, one in observable_series(run).items()}
        nothing = np.empty(0)
        found = {name: known.get(name, nothing) for name in _names(run)}
        return {
            f"{name}.{how}": float(reduce(values[np.isfinite(values)])) if np.isfinite(values).any() else None
            for name, values in found.items()
            for how, reduce in _REDUCTIONS.items()
        }

    def units(self, run: RunSignals) -> Mapping[str, str]:
        found = observable_series(run).items()
        return {f"{name}.{how}": one.unit for name, one in found if one.unit for how in _REDUCTIONS}


def observables_of(runs: Iterable[RunSignals]) -> list[Metric]:
    """Return a metric for each observable that some of the runs recorded."""
    found = {name: one.unit for run in runs for name, one in observable_series(run).items()}
    return [_metric_of(name, unit) for name, unit in found.items()]


def _metric_of(name: str, unit_: str) -> Metric:
    class OneObservable(ObservableValues):
        """The values of one observable, in its unit."""

        title, unit, is_compared = f"Observable {name}", unit_, True
        margin = Margin(at_least=_UNNOTICED.get(unit_, 0.0))

        def values(self, run: RunSignals) -> Mapping[str, float | None]:
            found = super().values(run).items()
            return {part: value for part, value in found if part.rpartition(".")[0] == name}

        def resolution(self, run: RunSignals) -> float:
            return 1e-9

    return OneObservable()


def observable_series(run: RunSignals) -> dict[str, Series]:
    """Return the values of each observable that a run recorded, by the name of the observable."""
    recorded = {one.name: one for one in run.numbers.with_role(Role.PUBLISHED)}
    return {name: recorded[topic_of(name)] for name in _names(run) if topic_of(name) in recorded}


def _names(run: RunSignals) -> Collection[str]:
    return (run.settings.get("observables") or {}).keys()


_REDUCTIONS: Mapping[str, Callable[[FloatArray], Any]] = {
    "min": np.min, "max": np.max, "mean": np.mean, "last": lambda values: values[-1],
}  # fmt: skip
_UNNOTICED = {"m": 0.01, "rad": 2 * pi / 180, "Hz": 1.0}
"""Differences of observables that users of a robot do not notice, by unit."""
_SMALL = 20
"""Populations up to this size are reported neuron by neuron."""
_MAX_TRAINS = 50
"""Of larger groups, this many neurons, evenly spread, represent all in a distance."""
_FEWEST_INTERVALS = 3
_TAU_S = 0.02
"""About the time constant of a membrane: the resolution of the next neuron."""


class FiringRate(ScalarMetric):
    """Spikes per neuron and second, of groups and of the neurons of small populations."""

    name, title, unit = "rate", "Firing rate", "Hz"
    margin = Margin(at_least=1.0)  # a spike a second

    def values(self, run: RunSignals) -> Mapping[str, float]:
        return {
            part: sum(map(len, trains)) / (max(len(trains), 1) * (run.duration_s or 1.0))
            for part, trains in _parts(run)
        }

    def resolution(self, run: RunSignals) -> float:
        """One spike in a run."""
        return 1.0 / (run.duration_s or 1.0)


class Activity(ScalarMetric):
    """Spikes of all neurons, and the synapses that they reach (synaptic events), in a simulated second."""

    name, title, unit = "activity", "Activity", "Hz"
    is_compared = False  # as are the rates of populations
    margin = Margin(at_least=1.0)  # a spike a second
    needs_recording = False

    def parts(self, experiment: Experiment) -> Collection[str]:
        return "spikes", "synaptic_events"

    def values(self, run: RunSignals) -> Mapping[str, float]:
        activity, end_s = run.result.get("activity") or {}, run.result.get("sim_time_s")
        return {name: count / end_s for name, count in activity.items()} if end_s else {}


class Irregularity(ScalarMetric):
    """Coefficient of variation of the intervals between spikes: 0 for a clock, 1 for a Poisson process."""

    name, title = "cv", "Irregularity (CV)"
    margin = Margin(at_least=0.05)  # cells of one kind differ more

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        return {part: _mean_cv(trains) for part, trains in _parts(run)}

    def resolution(self, run: RunSignals) -> float:
        return 1e-3


class SpikeTrains(DistanceMetric):
    """Van Rossum distance between the trains of each neuron, averaged over the neurons of a population.

    With 20 ms, one spike more or less is a distance of 1; a spike that is late by 2 ms is one of 0.4.
    """

    name, title = "spike_trains", "Spike trains (van Rossum)"

    def features(self, run: RunSignals) -> Mapping[str, FloatArray]:
        found = {}
        for label in run.numbers.spikes:
            trains = run.trains_s(label)
            chosen = np.linspace(0, len(trains) - 1, min(len(trains), _MAX_TRAINS)).round().astype(int)
            found[label] = filtered_trains([trains[i] for i in chosen], run.duration_s, _TAU_S)
        return found

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        samples = min(one.shape[1], other.shape[1])
        return float(np.linalg.norm(one[:, :samples] - other[:, :samples], axis=1).mean())

    def resolution(self, run: RunSignals) -> float:
        return 1e-6


def _parts(run: RunSignals) -> Iterator[tuple[str, list[FloatArray]]]:
    for group in run.groups:
        yield group, run.trains_s(group)
    for label in run.numbers.spikes:
        trains = run.trains_s(label)
        if 1 < len(trains) <= _SMALL:
            yield from ((f"{label}[{number}]", [train]) for number, train in enumerate(trains))


def _mean_cv(trains_s: list[FloatArray]) -> float | None:
    """Return the mean over the neurons with enough spikes; None without any."""
    intervals = [np.diff(train) for train in trains_s if len(train) > _FEWEST_INTERVALS]
    values = [float(one.std(ddof=1) / one.mean()) for one in intervals if one.mean() > 0]
    return float(np.mean(values)) if values else None


class DeviceValues(ScalarMetric):
    """The mean of each device's value over time, in the device's own unit."""

    name, title = "devices", "Device values (mean)"

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        series = run.numbers.with_role(Role.SINK, Role.SOURCE)
        means = {one.name.removeprefix("/brain/devices/"): run.held(one) for one in series}
        return {
            name: float(np.nanmean(values)) if np.isfinite(values).any() else None
            for name, values in means.items()
        }

    def resolution(self, run: RunSignals) -> float:
        return 1e-9


_POINTS = 200
"""The largest number of points of a compared trajectory; the cost of DTW is its square."""
_MM = 1e-3
_MOVING = 1e-3
"""Mean commands below this, m/s or rad/s, are too small to measure a response."""


def poses(run: RunSignals, robot: str) -> FloatArray:
    """Return the pose of a robot after each step since its first, m and quaternion, shape ``(n, 7)``."""
    values = run.held(run.motion(robot))[:, :7]
    return values[np.isfinite(values[:, 0])]


class Trajectory(DistanceMetric):
    """Mean distance of two trajectories, m, aligned in time (DTW)."""

    name, title, unit = "trajectory", "Trajectory (DTW)", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length

    def features(self, run: RunSignals) -> Mapping[str, FloatArray]:
        def thinned(robot: str) -> FloatArray:
            path = poses(run, robot)[:, :3]
            chosen = np.linspace(0, len(path) - 1, min(len(path), _POINTS)).round().astype(int)
            return np.ascontiguousarray(path[chosen])

        return {robot: thinned(robot) for robot in run.robots}

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        return dtw_distance(one, other)

    def resolution(self, run: RunSignals) -> float:
        return _MM


class FinalPosition(DistanceMetric):
    """The position of the robot at the end, m."""

    name, title, unit = "final_position", "Final position", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length

    def features(self, run: RunSignals) -> Mapping[str, FloatArray]:
        return {robot: poses(run, robot)[-1, :3] for robot in run.robots}

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        return float(np.linalg.norm(one - other))

    def resolution(self, run: RunSignals) -> float:
        return _MM


class FinalHeading(DistanceMetric):
    """The heading of the robot at the end, rad; differences are taken the shorter way round."""

    name, title, unit = "final_heading", "Final heading", "rad"
    margin = Margin(at_least=2 * pi / 180)  # two degrees, as a compass has

    def features(self, run: RunSignals) -> Mapping[str, float]:
        ends = {robot: poses(run, robot)[-1, 3:] for robot in run.robots}
        return {robot: Pose(orientation=tuple(end)).yaw for robot, end in ends.items()}

    def distance(self, one: float, other: float) -> float:
        return abs(atan2(sin(one - other), cos(one - other)))

    def resolution(self, run: RunSignals) -> float:
        return 0.1 * pi / 180


class Distance(ScalarMetric):
    """The distance that the robot has covered, m."""

    name, title, unit = "distance", "Distance covered", "m"
    margin = Margin(at_least=0.05)  # a tenth of a small robot's length

    def parts(self, experiment: Experiment) -> Collection[str]:
        return experiment.world.robots.keys()

    def values(self, run: RunSignals) -> Mapping[str, float]:
        steps = {robot: np.diff(poses(run, robot)[:, :3], axis=0) for robot in run.robots}
        return {robot: float(np.linalg.norm(step, axis=1).sum()) for robot, step in steps.items()}

    def resolution(self, run: RunSignals) -> float:
        return _MM


class DriveResponse(ScalarMetric):
    """The response of a robot to its commands: how far it drives and turns per metre and radian commanded.

    For robots commanded on ``/ROBOT/...`` by ``geometry_msgs/Twist``. A wheel that is 2 % larger than the
    drive assumes shows as 1.02.
    """

    name, title = "drive_response", "Drive response"
    margin = Margin(at_least=0.01)  # a centimetre in a metre, as of real wheels

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        found: dict[str, float | None] = {}
        for robot, command in self._commands(run):
            commanded, done = run.held(command)[:-1], self._motion(run, robot)
            steps = min(len(commanded), len(done["turn"]))
            for name, column in (("forward", "linear.x"), ("turn", "angular.z")):
                wanted = np.nan_to_num(commanded[:steps, command.columns.index(column)])
                effort = float(np.abs(wanted).mean()) if steps else 0.0
                made = done[name][:steps] * np.sign(wanted)
                found[f"{robot}/{name}"] = float(made.mean()) / effort if effort > _MOVING else None
        return found

    def resolution(self, run: RunSignals) -> float:
        return 1e-3

    @staticmethod
    def _commands(run: RunSignals) -> Iterator[tuple[str, Series]]:
        for robot in run.robots:
            for series in run.numbers.with_role(Role.PUBLISHED):
                if series.name.startswith(f"/{robot}/") and {"linear.x", "angular.z"} <= {*series.columns}:
                    yield robot, series

    @staticmethod
    def _motion(run: RunSignals, robot: str) -> Mapping[str, FloatArray]:
        """Return the mean speeds of each step: forward, m/s, and turning, rad/s."""
        values = run.held(run.motion(robot))
        yaws = np.array([Pose(orientation=tuple(q)).yaw for q in values[:, 3:7]])
        moved = np.diff(values[:, :2], axis=0) / run.step_s
        turned = np.diff(np.unwrap(yaws)) / run.step_s
        middle = np.unwrap(yaws)[:-1] + turned * run.step_s / 2
        forward = moved[:, 0] * np.cos(middle) + moved[:, 1] * np.sin(middle)
        return {"forward": forward, "turn": turned}
