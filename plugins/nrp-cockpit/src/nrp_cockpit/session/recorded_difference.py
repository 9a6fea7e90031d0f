"""The difference of two recorded runs at each of their common steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from nrp_lab.comparison import NOISE

from nrp_cockpit.session.difference import MOST_POINTS, beside_data
from nrp_core.brain import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.recording import Recording, Role


class RecordedDifference:
    """Compares two recordings, which are read once.

    Args:
        one: the leading recording.
        other: the recording that follows it.
    """

    def __init__(self, one: Recording, other: Recording) -> None:
        self._results = [recording.run.get("result") or {} for recording in (one, other)]
        here, there = _Signals(one), _Signals(other)
        self._spikes = (here.spikes, there.spikes)
        self.times_ns, at_here, at_there = np.intersect1d(here.times_ns, there.times_ns, return_indices=True)
        self.distances_m = np.zeros(len(self.times_ns))
        for robot in here.positions.keys() & there.positions.keys():
            apart = here.positions[robot][at_here] - there.positions[robot][at_there]
            np.fmax(self.distances_m, np.linalg.norm(apart, axis=1), out=self.distances_m)
        found = {"trajectory": self._first_apart(), "spikes": self._first_other_count()}
        self.first_ns = {name: t_ns for name, t_ns in found.items() if t_ns is not None}

    def _first_apart(self) -> int | None:
        apart = np.flatnonzero(self.distances_m > NOISE)
        return int(self.times_ns[apart[0]]) if len(apart) else None

    def _first_other_count(self) -> int | None:
        """Return the first common step at which the number of spikes of a population differs."""
        here, there = self._spikes
        apart = np.zeros(len(self.times_ns), bool)
        for name in here.keys() & there.keys():
            apart |= here[name].until(self.times_ns) != there[name].until(self.times_ns)
        return int(self.times_ns[np.argmax(apart)]) if apart.any() else None

    def data(self, t_ns: int) -> dict[str, Any]:
        """Return the difference at a time, or at the last common step before it, as data for the page."""
        count = int(np.searchsorted(self.times_ns, t_ns, "right"))
        shown = slice(0, count, max(1, -(-count // MOST_POINTS)))
        return {
            "since_s": seconds(int(self.times_ns[0])) if len(self.times_ns) else 0.0,
            "distance_m": float(self.distances_m[count - 1]) if count else 0.0,
            "distances": [
                [seconds(at_ns), distance_m]
                for at_ns, distance_m in zip(
                    self.times_ns[shown].tolist(), self.distances_m[shown].tolist(), strict=True
                )
            ],
            "first": [
                {"what": name, "t_s": seconds(first_ns)}
                for name, first_ns in sorted(self.first_ns.items(), key=lambda each: each[1])
                if first_ns <= t_ns
            ],
            "events": beside_data(*(_events(result, seconds(t_ns)) for result in self._results)),
            "criteria": beside_data(*(_passed(result, seconds(t_ns)) for result in self._results)),
            "spikes": beside_data(*(_counts(spikes, t_ns) for spikes in self._spikes)),
        }


class _Spikes:
    """The spikes of a population, counted at each of its messages."""

    def __init__(self, times_ns: list[int], counts: list[int]) -> None:
        self._times_ns = np.array(times_ns, np.int64)
        self._totals = np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))

    def until(self, times_ns: IntArray | int) -> IntArray:
        """Return how many there were until some times."""
        return np.asarray(self._totals[np.searchsorted(self._times_ns, times_ns, "right")])


class _Signals:
    """The positions of the models, m, and the spikes of a recording."""

    def __init__(self, recording: Recording) -> None:
        wanted = {each.name for each in recording.topics.values() if each.role in (Role.MODELS, Role.SPIKES)}
        times_ns: list[int] = []
        positions: list[dict[str, tuple[float, float, float]]] = []
        spikes: dict[str, tuple[list[int], list[int]]] = {}
        for one in recording.messages(wanted):
            if recording.topics[one.topic].role == Role.MODELS:
                times_ns.append(one.t_ns)
                points = [pose.position for pose in one.message.pose]
                positions.append(
                    {name: (at.x, at.y, at.z) for name, at in zip(one.message.name, points, strict=True)}
                )
            else:
                at_ns, counts = spikes.setdefault(one.message.population, ([], []))
                at_ns.append(one.t_ns)
                counts.append(len(one.message.ids))
        self.times_ns: IntArray = np.array(times_ns, np.int64)
        self.positions: dict[str, FloatArray] = {
            robot: np.array([each.get(robot, (np.nan,) * 3) for each in positions]).reshape(-1, 3)
            for robot in _robots(recording)
        }
        self.spikes = {name: _Spikes(*of) for name, of in spikes.items()}


def _robots(recording: Recording) -> list[str]:
    world = (recording.run.get("settings") or {}).get("world") or {}
    return list(world.get("robots") or ())


def _events(result: Mapping[str, Any], t_s: float) -> dict[str, float | None]:
    """Return when each event happened, if it did until a time."""
    events: Mapping[str, float | None] = result.get("events") or {}
    return {name: at_s if at_s is not None and at_s <= t_s else None for name, at_s in events.items()}


def _passed(result: Mapping[str, Any], t_s: float) -> dict[str, bool | None]:
    """Return the outcome of each criterion, if it was decided until a time."""
    criteria: Mapping[str, Mapping[str, Any]] = result.get("criteria") or {}
    return {
        name: one.get("passed") if (one.get("decided_s") or 0.0) <= t_s else None
        for name, one in criteria.items()
    }


def _counts(spikes: Mapping[str, _Spikes], t_ns: int) -> dict[str, int]:
    return {name: int(one.until(t_ns)) for name, one in spikes.items()}
