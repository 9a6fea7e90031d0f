"""The sentences of observables that the words of an experiment file mean."""

from __future__ import annotations

from numbers import Real
from typing import Any

from nrp_core.errors import TopicError
from nrp_core.experiment.model.event_schema import Near, Observed, StaysWithin, TopicIs
from nrp_core.observables.bodies import Displacement, Distance
from nrp_core.observables.condition import Condition, Sentence, value_in
from nrp_core.observables.observable import Surroundings, observable_of
from nrp_core.observables.topics import Field

_NUMBER, _TRUTH, _TEXT = "a number", "true or false", "a text"


def near_sentence(near: Near, around: Surroundings) -> Sentence:
    """Return the sentence of ``near``: a distance is at most so large.

    Raises:
        SceneError: the scene does not have the model or visual, or a joint moves the visual relative to its
            model.
        CapabilityError: the visual is a mesh, or the world does not report poses of models.
    """
    target = near.visual or near.other or near.point
    assert target is not None  # as the section requires
    distance = Distance(around, near.model, target)
    return Sentence(distance, Condition(below=near.within, reaches=True))


def stays_sentence(stays: StaysWithin, around: Surroundings) -> Sentence:
    """Return the sentence of ``stays_within``: a displacement is at most so large."""
    displacement = Displacement(around, stays.model, None if isinstance(stays.of, str) else stays.of)
    return Sentence(displacement, Condition(below=stays.distance, reaches=True))


def topic_sentence(wanted: TopicIs, around: Surroundings) -> Sentence:
    """Return the sentence of a condition on the last message of a topic.

    Raises:
        TopicError: the topic does not exist, its message lacks the field, or the values cannot be
            compared.
    """
    field = Field(around, wanted.name, wanted.field)
    field.name = wanted.name
    _require_comparable(wanted, field.example)
    return Sentence(field, Condition(wanted.above, wanted.below, wanted.equals))


def observed_sentence(wanted: Observed, around: Surroundings) -> Sentence:
    """Return the sentence of a condition on an observable.

    Raises:
        ExperimentError: the observable does not exist, or a bound has another unit.
    """
    observable = observable_of(wanted.observable, around)

    def bound(written: Any) -> float | None:
        return None if written is None else value_in(written, observable.unit)

    if wanted.between is not None:
        low, high = (value_in(one, observable.unit) for one in wanted.between)
        return Sentence(observable, Condition(low, high, reaches=True))
    return Sentence(observable, Condition(bound(wanted.above), bound(wanted.below), wanted.equals))


def _require_comparable(wanted: TopicIs, example: Any) -> None:
    what = f"'{wanted.field}' of {wanted.name} is {_kind(example)}"
    if (wanted.above is not None or wanted.below is not None) and _kind(example) != _NUMBER:
        raise TopicError(f"'above' and 'below' are for numbers, and {what}")
    if wanted.equals is not None and _kind(wanted.equals) != _kind(example):
        raise TopicError(f"'equals' is {wanted.equals!r}, and {what}")
    if wanted.equals is not None and _kind(example) not in (_NUMBER, _TRUTH, _TEXT):
        raise TopicError(f"'equals' is for numbers, texts, true and false, and {what}")


def _kind(value: Any) -> str:
    """Return a text with the types that a value can be compared with."""
    if isinstance(value, bool):
        return _TRUTH
    if isinstance(value, Real):
        return _NUMBER
    if isinstance(value, str):
        return _TEXT
    return "a list" if hasattr(value, "__len__") else f"a {type(value).__name__}"
