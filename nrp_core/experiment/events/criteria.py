"""Criteria of a running experiment: evaluated at every step as passed, failed or not decided yet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf
from typing import Any, final

from nrp_core._support.checked_arguments import is_number
from nrp_core.clock import seconds
from nrp_core.experiment.events.events import Times, TopicSays
from nrp_core.experiment.events.ground_positions import GroundPoint, GroundPositions, Proximity, require_poses
from nrp_core.experiment.model.event_schema import (
    START,
    Criterion,
    During,
    Near,
    StaysWithin,
    TopicStays,
    WithinOf,
)
from nrp_core.quantities import length_text
from nrp_core.scene.model import Scene
from nrp_core.world.world import World


@dataclass(frozen=True, slots=True)
class Verdict:
    """The outcome of a criterion.

    Args:
        passed: None: not decided.
        decided_s: simulated time of the decision, s.
        took_s: time from the start of the criterion to the decision, s.
        distance: the decisive distance, m: the smallest of a ``near``, the largest of a ``stays_within``.
        limit: the limit of the distance, m; None for other criteria.
        reason: the outcome as a text.
        degree: how nearly it is met, from 0 to 1. Of a ``near``, the share of the way from the first distance
            to the limit; of others, the share of the steps in which the condition held. None: not evaluated.
    """

    passed: bool | None
    decided_s: float | None
    took_s: float | None
    distance: float | None
    limit: float | None
    reason: str
    degree: float | None = None


class Judge(ABC):
    """Decides one criterion.

    Args:
        begins: the start of its evaluation.
        limit: the limit of the distance, m, if it has one.
    """

    def __init__(self, begins: int | str, limit: float | None = None) -> None:
        self._begins, self._limit = begins, limit
        self._began_ns: int | None = None
        self._decided_ns: int | None = None
        self._passed: bool | None = None
        self._distance: float | None = None
        self._reason = "not decided"
        self._between = False
        self._is_over = False  # whether later steps change nothing, not even the degree

    def news(self) -> Sequence[int]:
        """Return the times of the messages that came since the last call, ns."""
        return ()

    def unchanged_ns(self, where: GroundPositions) -> int | None:
        """Return for how long its distance surely keeps on the same side of the limit, ns."""
        return None

    @final
    def evaluate(self, now_ns: int, times: Times, where: GroundPositions, *, between: bool = False) -> None:
        """Evaluate a moment.

        Args:
            now_ns: the moment.
            times: the times of the past events.
            where: the positions at this moment.
            between: whether it lies between two steps of the loop.
        """
        if self._is_over:
            return
        self._between = between
        if self._began_ns is None:
            begins_ns = start_or_event_ns(self._begins, times)
            if begins_ns is None or now_ns < begins_ns:
                return
            self._began_ns = begins_ns
        self._evaluate(now_ns, self._began_ns, times, where)

    @final
    def finish(self, now_ns: int) -> None:
        """Decide at the end of a complete run (a run that ended early does not decide)."""
        if self._passed is not None:
            return
        if self._began_ns is None:
            begins = self._begins
            reason = f"{begins} did not happen" if isinstance(begins, str) else _early(now_ns, begins)
            self._decide(False, now_ns, f"was never evaluated: {reason}")
        else:
            self._finish(now_ns)

    @property
    def passed(self) -> bool | None:
        """Whether the criterion is met so far; None: it is not decided."""
        return self._passed

    @property
    def outcome(self) -> Verdict:
        """The outcome so far."""
        decided, began = self._decided_ns, self._began_ns
        took_s = None if decided is None or began is None else seconds(decided - began)
        decided_s = None if decided is None else seconds(decided)
        degree = 0.0 if began is None and decided is not None else self._degree()
        return Verdict(self._passed, decided_s, took_s, self._distance, self._limit, self._reason, degree)

    def outcome_at(self, end_ns: int | None) -> Verdict:
        """Return the outcome so far, or if the run ended at ``end_ns``; the judge stays as it is."""
        if end_ns is None:
            return self.outcome
        before = self.save()
        try:
            self.finish(end_ns)
            return self.outcome
        finally:
            self.restore(before)

    def save(self) -> Any:
        """Return the state that changes during a run."""
        return self._began_ns, self._decided_ns, self._passed, self._distance, self._reason, self._is_over

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._began_ns, self._decided_ns, self._passed, self._distance, self._reason, self._is_over = saved

    def _decide(self, passed: bool, now_ns: int, reason: str) -> None:
        self._passed, self._decided_ns, self._reason = passed, now_ns, reason
        self._is_over = True

    @abstractmethod
    def _degree(self) -> float | None:
        """Return how nearly the criterion is met so far; None before its first step."""

    @abstractmethod
    def _evaluate(self, now_ns: int, began_ns: int, times: Times, where: GroundPositions) -> None: ...

    @abstractmethod
    def _finish(self, now_ns: int) -> None: ...


class ComesNear(Judge):
    """A model comes near a target in time."""

    def __init__(self, near: Near, within_of: WithinOf | None, scene: Scene) -> None:
        super().__init__(START if within_of is None else within_of.event, near.within)
        self._proximity, self._within = Proximity(near, scene), near.within
        self._time_ns = None if within_of is None else within_of.time
        self._first: float | None = None

    def unchanged_ns(self, where: GroundPositions) -> int | None:
        return None if self._is_over else self._proximity.unchanged_ns(where)

    def save(self) -> Any:
        return super().save(), self._first

    def restore(self, saved: Any) -> None:
        judged, self._first = saved
        super().restore(judged)

    def _degree(self) -> float | None:
        if self._passed or self._first is None or self._distance is None:
            return 1.0 if self._passed else None
        return (self._first - self._distance) / (self._first - self._within)

    def _evaluate(self, now_ns: int, began_ns: int, times: Times, where: GroundPositions) -> None:
        if self._time_ns is not None and now_ns > began_ns + self._time_ns:
            self._decide(False, now_ns, f"{self._nearest()} after {seconds(self._time_ns):g} s")
            return
        distance = self._proximity.distance(where)
        self._first = distance if self._first is None else self._first
        self._distance = min(distance, inf if self._distance is None else self._distance)
        if distance <= self._within:
            self._decide(True, now_ns, f"{length_text(distance)} after {seconds(now_ns - began_ns):g} s")

    def _finish(self, now_ns: int) -> None:
        self._decide(False, now_ns, f"{self._nearest()} by the end of the run")

    def _nearest(self) -> str:
        return f"no nearer than {length_text(self._distance or 0.0)}, not {self._within:g} m,"


class Throughout(Judge):
    """A condition holds at every moment of a part of the run."""

    def __init__(self, during: During, limit: float | None = None) -> None:
        super().__init__(during.since, limit)
        self._until = during.until
        self._steps = self._held = 0
        self._was_wrong = False

    def save(self) -> Any:
        return super().save(), self._steps, self._held

    def restore(self, saved: Any) -> None:
        judged, self._steps, self._held = saved
        self._was_wrong = False
        super().restore(judged)

    def _degree(self) -> float | None:
        if not self._steps:
            return None if self._passed is None else 0.0
        return self._held / self._steps

    def _evaluate(self, now_ns: int, began_ns: int, times: Times, where: GroundPositions) -> None:
        until_ns = start_or_event_ns(self._until, times)
        if until_ns is None or now_ns <= until_ns:
            wrong = self._wrong(now_ns, times, where)
            self._was_wrong |= wrong is not None
            if not self._between:
                self._steps += 1
                self._held += not self._was_wrong
                self._was_wrong = False
            if wrong is not None and self._passed is None:
                self._decide(False, now_ns, wrong)
        has_ended = until_ns is not None and now_ns >= until_ns
        if has_ended and self._passed is None:
            if self._steps:
                self._finish(now_ns)
            else:
                self._decide(False, now_ns, "was never evaluated: no step of the run lies in its period")
        self._is_over = has_ended

    @abstractmethod
    def _wrong(self, now_ns: int, times: Times, where: GroundPositions) -> str | None:
        """Return a description of a violation now, if there is one."""


class Stays(Throughout):
    """A model does not leave a circle on the ground."""

    def __init__(self, stays: StaysWithin, scene: Scene) -> None:
        super().__init__(stays.during, stays.distance)
        self._model, self._radius = scene.model(stays.model).name, stays.distance
        self._centre: GroundPoint | None = None if isinstance(stays.of, str) else stays.of

    def unchanged_ns(self, where: GroundPositions) -> int | None:
        if self._centre is None or self._passed is not None:
            return None
        return where.unchanged_ns(self._radius - self._away(where, self._centre), self._model)

    def _away(self, where: GroundPositions, centre: GroundPoint) -> float:
        x, y = where.ground(self._model)
        return hypot(x - centre[0], y - centre[1])

    def save(self) -> Any:
        return super().save(), self._centre

    def restore(self, saved: Any) -> None:
        judged, self._centre = saved
        super().restore(judged)

    def _wrong(self, now_ns: int, times: Times, where: GroundPositions) -> str | None:
        self._centre = self._centre or where.ground(self._model)
        distance = self._away(where, self._centre)
        if self._passed is None:
            self._distance = max(distance, self._distance or 0.0)
        return (
            f"{length_text(distance)} away, more than {self._radius:g} m" if distance > self._radius else None
        )

    def _finish(self, now_ns: int) -> None:
        self._decide(True, now_ns, f"never more than {length_text(self._distance or 0.0)} away")


class StaysSo(Throughout):
    """The values of a topic stay in limits; without a later beginning from its first message on."""

    def __init__(self, stays: TopicStays, world: World) -> None:
        super().__init__(stays.during)
        self._may_be_silent = stays.during.since == START
        self._topic, self._says = stays.name, TopicSays(stays, world)
        self.news = self._says.news  # type: ignore[method-assign]
        bounds = {"above": stays.above, "below": stays.below, "equal to": stays.equals}
        self._wanted = " and ".join(f"{how} {value}" for how, value in bounds.items() if value is not None)

    def unchanged_ns(self, where: GroundPositions) -> int | None:
        return self._says.unchanged_ns if self._passed is None else None

    def restore(self, saved: Any) -> None:
        self._says.restore()
        super().restore(saved)

    def _wrong(self, now_ns: int, times: Times, where: GroundPositions) -> str | None:
        if self._says(now_ns, times):
            return None
        value = self._says.value
        if value is None and self._may_be_silent:
            return None
        text = "without a value" if value is None else f"{value:.6g}" if is_number(value) else repr(value)
        return f"{self._topic} was {text} at {seconds(now_ns):g} s, not {self._wanted}"

    def _finish(self, now_ns: int) -> None:
        if self._says.value is None:
            self._decide(False, now_ns, f"{self._topic} never carried a message")
        else:
            self._decide(True, now_ns, f"{self._topic} stayed {self._wanted}")


def judge_of(criterion: Criterion, world: World) -> Judge:
    """Return the judge of a criterion.

    Raises:
        SceneError: it names an object that is not in the scene.
        TopicError: it names a topic or a field that does not exist.
        CapabilityError: it needs a distance, and the world does not report poses of models.
    """
    if criterion.stays_within is not None:
        require_poses(world)
        return Stays(criterion.stays_within, world.scene)
    if criterion.topic_stays is not None:
        return StaysSo(criterion.topic_stays, world)
    assert criterion.near is not None  # checked when it was read
    require_poses(world)
    return ComesNear(criterion.near, criterion.within_of, world.scene)


def _early(end_ns: int, begins_ns: int) -> str:
    return f"the run ended at {seconds(end_ns):g} s, and it begins at {seconds(begins_ns):g} s"


def start_or_event_ns(point: int | str, times: Times) -> int | None:
    """Return the time of a point of the run: a time, ``start``, or an event; None for a future event."""
    if isinstance(point, int):
        return point
    return 0 if point == START else times.get(point)
