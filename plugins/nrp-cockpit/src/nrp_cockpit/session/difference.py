"""The difference of two runs in step: positions of robots, events, and the time of the first difference."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain
from math import dist
from typing import Any

from nrp_lab.comparison import NOISE

from nrp_core.clock import seconds
from nrp_core.experiment import Result, Run

MOST_POINTS = 600
"""Maximum number of points of the distance over time; beyond it, every second point is removed."""


class Difference:
    """Compares two runs after each common step.

    Args:
        one: the leading run.
        other: the run that follows it.

    Attributes:
        since_ns: the time from which they are compared.
    """

    def __init__(self, one: Run, other: Run) -> None:
        self._one, self._other = one, other
        self.since_ns = other.loop.now_ns
        self._distances: list[tuple[int, float]] = []
        self._every = 1
        self._steps = 0
        self._first: dict[str, int] = {}
        self._shown = self._data_now()

    def update(self) -> None:
        """Compare them now."""
        now_ns = self._one.loop.now_ns
        distance_m = self.distance_m
        if distance_m > NOISE:
            self._first.setdefault("trajectory", now_ns)
        if self._one.spikes != self._other.spikes:
            self._first.setdefault("spikes", now_ns)
        if self._steps % self._every == 0:
            self._distances.append((now_ns, distance_m))
        self._steps += 1
        if len(self._distances) > MOST_POINTS:
            self._distances, self._every = self._distances[::2], self._every * 2

    def cut(self, t_ns: int) -> None:
        """Forget all differences after a time."""
        self._distances = [each for each in self._distances if each[0] <= t_ns]
        self._first = {name: first_ns for name, first_ns in self._first.items() if first_ns <= t_ns}

    @property
    def distance_m(self) -> float:
        """The largest distance between the two positions of a robot, m."""
        there = {model.name for model in self._other.world.scene.models}
        robots = [
            name
            for name in self._one.experiment.world.robots
            if name in there and any(model.name == name for model in self._one.world.scene.models)
        ]
        return max(
            (dist(*(run.world.model_motion(name).pose.position for run in self._runs)) for name in robots),
            default=0.0,
        )

    def data(self) -> dict[str, Any]:
        """Return the difference at the last time that both had reached, as data for the page."""
        if self._one.loop.now_ns == self._other.loop.now_ns:
            self._shown = self._data_now()
        return self._shown

    def _data_now(self) -> dict[str, Any]:
        one, other = (run.result() for run in self._runs)
        return {
            "since_s": seconds(self.since_ns),
            "distance_m": self.distance_m,
            "distances": [[seconds(t_ns), distance_m] for t_ns, distance_m in self._distances],
            "first": [
                {"what": name, "t_s": seconds(t_ns)}
                for name, t_ns in sorted(self._first.items(), key=lambda each: each[1])
            ],
            "events": beside_data(one.events, other.events),
            "criteria": beside_data(_passed(one), _passed(other)),
            "spikes": beside_data(one.spikes, other.spikes),
        }

    @property
    def _runs(self) -> tuple[Run, Run]:
        return self._one, self._other


def _passed(result: Result) -> Mapping[str, bool | None]:
    return {name: outcome.passed for name, outcome in result.criteria.items()}


def beside_data(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the values of two runs by name, as data for the page."""
    names: Iterable[str] = dict.fromkeys(chain(one, other))
    return [{"name": name, "one": one.get(name), "other": other.get(name)} for name in names]
