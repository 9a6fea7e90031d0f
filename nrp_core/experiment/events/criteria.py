"""Criteria of a running experiment: evaluated at every step as passed, failed or not decided yet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, final

from nrp_core.clock import seconds
from nrp_core.experiment.events.events import Times
from nrp_core.experiment.events.lanes import ALONE, NEVER, Lane, LaneKind
from nrp_core.experiment.events.sentences import (
    near_sentence,
    observed_sentence,
    stays_sentence,
    topic_sentence,
)
from nrp_core.experiment.model.event_schema import END, START, Criterion, During, Near
from nrp_core.observables.condition import Sentence
from nrp_core.observables.observable import Surroundings
from nrp_core.observables.topics import Field
from nrp_core.quantities import length_text


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
        sentence: an observable and a condition on it.
        begins: the start of its evaluation.
        limit: the limit of the distance, m, if it has one.
    """

    def __init__(self, sentence: Sentence, begins: int | str, limit: float | None = None) -> None:
        self._sentence, self._begins, self._limit = sentence, begins, limit
        self.news, self.look, self.hears = sentence.news, sentence.look, sentence.hears
        self._began_ns: int | None = None
        self._decided_ns: int | None = None
        self._passed: bool | None = None
        self._distance: float | None = None
        self._reason = "not decided"
        self._between = False
        self._is_over = False  # whether later steps change nothing, not even the degree

    def unchanged_ns(self, now_ns: int) -> int | None:
        """Return the time for which its condition cannot change, ns."""
        is_open = self._began_ns is not None and self._passed is None
        return self._sentence.unchanged_ns(now_ns) if is_open else None

    @final
    def evaluate(self, now_ns: int, times: Times, *, between: bool = False) -> None:
        """Evaluate a moment.

        Args:
            now_ns: the moment.
            times: the times of the past events.
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
        self._evaluate(now_ns, self._began_ns, times)

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
        judged = self._began_ns, self._decided_ns, self._passed, self._distance, self._reason, self._is_over
        return judged, self._sentence.observable.save()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        judged, observed = saved
        self._began_ns, self._decided_ns, self._passed, self._distance, self._reason, self._is_over = judged
        self._sentence.observable.restore(observed)

    def _decide(self, passed: bool, now_ns: int, reason: str) -> None:
        self._passed, self._decided_ns, self._reason = passed, now_ns, reason
        self._is_over = True

    # -- in many copies at once; see Lane

    @property
    def sentence(self) -> Sentence:
        """The observable and the condition."""
        return self._sentence

    def lane_kind(self, moving: Sequence[str]) -> LaneKind | None:
        """Return how arrays can evaluate it, given the names of the models that move; None: they cannot."""
        return None

    @final
    def lane(self, times: Times) -> Lane:
        """Return its present state."""
        if self._is_over:
            return Lane(NEVER)
        if self._began_ns is None:
            begins_ns = start_or_event_ns(self._begins, times)
            return Lane(NEVER if begins_ns is None else begins_ns)
        return self._open_lane(self._began_ns, times)

    def _open_lane(self, began_ns: int, times: Times) -> Lane:
        return ALONE

    def settle(self, numbers: Sequence[float], value: float | None) -> None:
        """Set the state that its lane has reached, and the last value."""
        self._sentence.value = value
        self._settle(*numbers)

    def _settle(self, first: float, second: float, third: float) -> None:
        """Set the numbers of :class:`Lane`."""

    @abstractmethod
    def _degree(self) -> float | None:
        """Return how nearly the criterion is met so far; None before its first step."""

    @abstractmethod
    def _evaluate(self, now_ns: int, began_ns: int, times: Times) -> None: ...

    @abstractmethod
    def _finish(self, now_ns: int) -> None: ...


class Once(Judge):
    """A condition holds at some moment, or for some time without a gap.

    Args:
        sentence: the observable and the condition.
        begins: the start of its evaluation.
        time_ns: how long it may take from there on; None: until ``by``.
        by: when it must hold at the latest.
        lasting_ns: for how long it must hold.
        limit: as of :class:`Judge`.
    """

    def __init__(
        self,
        sentence: Sentence,
        begins: int | str,
        time_ns: int | None = None,
        by: int | str = END,
        lasting_ns: int = 0,
        limit: float | None = None,
    ) -> None:
        super().__init__(sentence, begins, limit)
        self._time_ns, self._by, self._lasting_ns = time_ns, by, lasting_ns
        self._first_gap: float | None = None
        self._least_gap: float | None = None
        self._nearest_text = "without a value"
        self._since_ns: int | None = None

    def save(self) -> Any:
        return super().save(), self._first_gap, self._least_gap, self._nearest_text, self._since_ns

    def restore(self, saved: Any) -> None:
        judged, self._first_gap, self._least_gap, self._nearest_text, self._since_ns = saved
        super().restore(judged)

    def _degree(self) -> float | None:
        if self._passed:
            return 1.0
        if self._first_gap is None or self._least_gap is None:
            return None if self._passed is None else 0.0
        whole = self._first_gap
        return 0.0 if whole <= 0 or whole == inf else max(0.0, min(1.0, (whole - self._least_gap) / whole))

    def _evaluate(self, now_ns: int, began_ns: int, times: Times) -> None:
        until_ns = self._until_ns(began_ns, times)
        if until_ns is not None and now_ns > until_ns:
            self._decide(False, now_ns, self._too_late(seconds(until_ns - began_ns)))
            return
        holds = self._sentence.holds(now_ns)
        self._note_gap()
        self._since_ns = (now_ns if self._since_ns is None else self._since_ns) if holds else None
        if self._since_ns is not None and now_ns - self._since_ns >= self._lasting_ns:
            proves_nothing = self._since_ns == began_ns == 0 and not self._lasting_ns
            remark = "; it holds at the start, so it proves nothing" if proves_nothing else ""
            self._decide(True, now_ns, self._reached(seconds(self._since_ns - began_ns)) + remark)

    def _until_ns(self, began_ns: int, times: Times) -> int | None:
        return began_ns + self._time_ns if self._time_ns is not None else start_or_event_ns(self._by, times)

    def _note_gap(self) -> None:
        value = self._sentence.value
        if value is None:
            return
        gap = self._sentence.condition.gap(value)
        self._first_gap = gap if self._first_gap is None else self._first_gap
        if self._least_gap is None or gap < self._least_gap:
            self._least_gap = gap
            if self._limit is None:  # not in each step of an approach: it takes time
                self._nearest_text = self._sentence.value_text()
            else:
                self._distance = float(value)

    def _finish(self, now_ns: int) -> None:
        self._decide(False, now_ns, self._too_late(None))

    def _reached(self, after_s: float) -> str:
        lasting = f", for {seconds(self._lasting_ns):g} s" if self._lasting_ns else ""
        named = self._sentence.observable.name
        return f"{named} was {self._sentence.value_text()} after {after_s:g} s{lasting}"

    def _too_late(self, after_s: float | None) -> str:
        """Return the reason of a failure, after some time or at the end of the run."""
        lasting = f" for {seconds(self._lasting_ns):g} s" if self._lasting_ns else ""
        never = f"{self._sentence.observable.name} was never {self._sentence.wanted}{lasting}"
        until = "by the end of the run" if after_s is None else f"by {after_s:g} s"
        return f"{never} {until}; the nearest was {self._nearest_text}"


class ComesNear(Once):
    """A model comes near a target in time."""

    def lane_kind(self, moving: Sequence[str]) -> LaneKind | None:
        return LaneKind.of(self._sentence, moving)

    def _open_lane(self, began_ns: int, times: Times) -> Lane:
        if self._least_gap is None or self._distance is None or self._since_ns is not None:
            return ALONE
        until_ns = self._until_ns(began_ns, times)
        numbers = self._least_gap, self._distance, 0.0
        return Lane(NEVER if until_ns is None else until_ns + 1, True, numbers)

    def _settle(self, first: float, second: float, third: float) -> None:
        self._least_gap, self._distance = first, second

    def _reached(self, after_s: float) -> str:
        return f"{length_text(self._sentence.value)} after {after_s:g} s"

    def _too_late(self, after_s: float | None) -> str:
        until = "by the end of the run" if after_s is None else f"after {after_s:g} s"
        return f"no nearer than {length_text(self._distance or 0.0)}, not {self._limit:g} m, {until}"


class Always(Judge):
    """A condition holds at every moment of a part of the run, or if that begins at 0 from the first value on.

    Args:
        sentence: the observable and the condition.
        during: the part of the run.
        limit: as of :class:`Judge`.
    """

    def __init__(self, sentence: Sentence, during: During, limit: float | None = None) -> None:
        super().__init__(sentence, during.since, limit)
        self._until = during.until
        self._may_be_silent = during.since == START
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

    def lane_kind(self, moving: Sequence[str]) -> LaneKind | None:
        return LaneKind.of(self._sentence, moving, counts=True, may_be_silent=self._may_be_silent)

    def _open_lane(self, began_ns: int, times: Times) -> Lane:
        until_ns = start_or_event_ns(self._until, times)
        numbers = self._steps, self._held, self._distance or 0.0
        return Lane(NEVER if until_ns is None else until_ns, True, numbers, decides=self._passed is None)

    def _settle(self, first: float, second: float, third: float) -> None:
        if self._limit is not None and self._passed is None and first > self._steps:
            self._distance = third
        self._steps, self._held = int(first), int(second)

    def _evaluate(self, now_ns: int, began_ns: int, times: Times) -> None:
        until_ns = start_or_event_ns(self._until, times)
        if until_ns is None or now_ns <= until_ns:
            wrong = self._wrong(now_ns)
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

    def _wrong(self, now_ns: int) -> str | None:
        """Return a description of the present violation, if any."""
        holds = self._sentence.holds(now_ns)
        if self._limit is not None and self._passed is None:
            self._distance = max(self._sentence.value, self._distance or 0.0)
        if holds or (self._sentence.value is None and self._may_be_silent):
            return None
        return self._violation(now_ns)

    def _violation(self, now_ns: int) -> str:
        named, text = self._sentence.observable.name, self._sentence.value_text()
        return f"{named} was {text} at {seconds(now_ns):g} s, not {self._sentence.wanted}"

    def _finish(self, now_ns: int) -> None:
        named = self._sentence.observable.name
        if self._sentence.value is None:
            is_topic = isinstance(self._sentence.observable, Field)
            self._decide(False, now_ns, f"{named} never {'carried a message' if is_topic else 'had a value'}")
        else:
            self._decide(True, now_ns, f"{named} stayed {self._sentence.wanted}")


class Stays(Always):
    """A model does not leave a circle on the ground."""

    def _violation(self, now_ns: int) -> str:
        return f"{length_text(self._sentence.value)} away, more than {self._limit:g} m"

    def _finish(self, now_ns: int) -> None:
        self._decide(True, now_ns, f"never more than {length_text(self._distance or 0.0)} away")


def judge_of(criterion: Criterion, around: Surroundings) -> Judge:
    """Return the judge of a criterion.

    Raises:
        SceneError: it names an object that is not in the scene.
        TopicError: it names a topic or a field that does not exist.
        CapabilityError: the world does not report data that it needs, such as poses of models.
        ExperimentError: its observable does not exist.
    """
    if criterion.stays_within is not None:
        stays = criterion.stays_within
        return Stays(stays_sentence(stays, around), stays.during, stays.distance)
    if criterion.topic_stays is not None:
        return Always(topic_sentence(criterion.topic_stays, around), criterion.topic_stays.during)
    if criterion.near is not None:
        return _comes_near(criterion, criterion.near, around)
    sentence, during = observed_sentence(criterion, around), criterion.during or During()
    if criterion.by is None and criterion.lasting is None:
        return Always(sentence, during)
    by = during.until if criterion.by is None else criterion.by
    return Once(sentence, during.since, by=by, lasting_ns=criterion.lasting or 0)


def _comes_near(criterion: Criterion, near: Near, around: Surroundings) -> Judge:
    limit = criterion.within_of
    begins, time_ns = (START, None) if limit is None else (limit.event, limit.time)
    return ComesNear(near_sentence(near, around), begins, time_ns, limit=near.within)


def _early(end_ns: int, begins_ns: int) -> str:
    return f"the run ended at {seconds(end_ns):g} s, and it begins at {seconds(begins_ns):g} s"


def start_or_event_ns(point: int | str, times: Times) -> int | None:
    """Return the time of a point of the run: a time, ``start``, or an event; None for a future event."""
    if isinstance(point, int):
        return point
    return 0 if point == START else times.get(point)
