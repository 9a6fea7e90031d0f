"""Events and criteria in the form of the experiment file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    PlainValidator,
    WithJsonSchema,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from nrp_core.experiment.model.section import Name, Section, TopicName
from nrp_core.observables.condition import quantity_of
from nrp_core.observables.observable import OBSERVABLES, arguments_of, kind_and_arguments
from nrp_core.quantities import DurationNs, LengthM, Point, TimeNs, length_m, time_ns

START, END = "start", "end"
"""Points in time of every run; events cannot have these names."""


def _time_or_event(value: object) -> int | str:
    if isinstance(value, str) and value.isidentifier():
        return str(value)
    try:
        return time_ns(value)
    except ValueError as error:
        raise ValueError(f"{error}; or the name of an event, 'start' or 'end'") from None


TimeOrEvent = Annotated[
    int | str,
    PlainValidator(_time_or_event),
    WithJsonSchema({"type": ["string", "number"], "description": "a time, an event, 'start' or 'end'"}),
]
"""A time in ns, the name of an event, ``start`` or ``end`` (of the run)."""


def _centre(value: object) -> str | Point:
    if value == START:
        return START
    if isinstance(value, (list, tuple)) and len(value) == 2:
        x, y = map(length_m, value)
        return x, y
    raise ValueError(f"is 'start' or a place [x, y], not {value!r}")


Centre = Annotated[
    str | Point,
    PlainValidator(_centre),
    WithJsonSchema({"anyOf": [{"const": START}, {"type": "array", "minItems": 2, "maxItems": 2}]}),
]
"""Where a model starts, or a place on the ground."""


class Near(Section):
    """A model is near something: the horizontal distance of its origin to it."""

    alternatives = ("visual", "other", "point")

    model: Name
    """The model whose origin counts."""
    visual: str | None = None
    """Near this visual, ``model/link/visual``: its nearest point counts."""
    other: Name | None = None
    """Near the origin of this model."""
    point: Point | None = None
    """Near this place on the ground."""
    within: Annotated[LengthM, Field(gt=0)]
    """Maximum distance."""

    @model_validator(mode="after")
    def _another_model(self) -> Near:
        if self.other == self.model:
            raise ValueError(f"'{self.model}' is always near itself: 'other' is another model")
        if self.visual is not None and self.visual.partition("/")[0] == self.model:
            raise ValueError(f"'{self.model}' is always near itself: 'visual' is of another model")
        return self


class TopicIs(Section):
    """A condition on the last message of a topic."""

    name: TopicName
    """The topic."""
    field: str = "data"
    """The field of its message, dotted: ``linear.x``."""
    above: float | None = None
    """More than this."""
    below: float | None = None
    """Less than this."""
    equals: Any = None
    """Exactly this."""

    @model_validator(mode="after")
    def _some_bound(self) -> TopicIs:
        if self.above is None and self.below is None and self.equals is None:
            raise ValueError("needs 'above', 'below' or 'equals'")
        return self


@dataclass(frozen=True)
class _ObservableSchema:
    """The JSON Schema of each installed kind of observable with its arguments, or of a name."""

    or_name: bool

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        kinds = {kind: arguments_of(kind).model_json_schema() for kind in OBSERVABLES.names()}
        for form in kinds.values():
            form.pop("required", None)  # a file that extends another need not repeat it
        one_kind = {
            "type": "object",
            "properties": {
                kind: {"anyOf": [form, *list(form["properties"].values())[:1], {"type": "array"}]}
                for kind, form in kinds.items()
            },
            "additionalProperties": False,
            "minProperties": 1,
            "maxProperties": 1,
        }
        return {"anyOf": [{"type": "string"}, one_kind]} if self.or_name else one_kind


def _known(written: Any) -> Any:
    kind_and_arguments(written)
    return written


def _named_or_known(written: Any) -> Any:
    return written if isinstance(written, str) else _known(written)


ObservableForm = Annotated[Any, AfterValidator(_known), _ObservableSchema(or_name=False)]
"""An observable as it is written: its kind and arguments."""


def _quantity(written: Any) -> Any:
    quantity_of(written)
    return written


Bound = Annotated[
    Any,
    AfterValidator(_quantity),
    WithJsonSchema({"type": ["number", "string"], "examples": ["1 m"]}),
]
"""A number in the unit of an observable, or with a unit of its own."""


class Observed(Section):
    """A condition on an observable."""

    observable: Annotated[Any, AfterValidator(_named_or_known), _ObservableSchema(or_name=True)] = None
    """The name of an observable of the experiment, or its kind and arguments: ``{height: husky}``."""
    above: Bound = None
    """More than this, in the unit of the observable or with its own unit: ``1 m``."""
    below: Bound = None
    """Less than this."""
    between: tuple[Bound, Bound] | None = None
    """From the first to the second, both included."""
    equals: Annotated[Any, WithJsonSchema({"type": ["number", "string", "boolean"]})] = None
    """Exactly this."""

    def _check_bounds(self) -> None:
        bounds = ("above", "below", "between", "equals")
        given = [name for name in bounds if getattr(self, name) is not None]
        if self.observable is None and given:
            raise ValueError(f"'{given[0]}' goes with 'observable'")
        if self.observable is not None and not given:
            raise ValueError("'observable' needs 'above', 'below', 'between' or 'equals'")
        if self.between is not None and len(given) > 1:
            raise ValueError("'between' is both bounds: leave out the others")


class When(Observed):
    """A condition; where several are given, all must hold at once."""

    near: Near | None = None
    """A model is near something."""
    event: Name | None = None
    """Another event has happened."""
    after: TimeNs = 0
    """Minimum time since that event; needs ``event``."""
    topic: TopicIs | None = None
    """A condition on a topic."""

    @model_validator(mode="after")
    def _some_condition(self) -> When:
        self._check_bounds()
        if self.near is None and self.event is None and self.topic is None and self.observable is None:
            raise ValueError("needs 'near', 'event', 'topic' or 'observable'")
        if "after" in self.model_fields_set and self.event is None:
            raise ValueError("'after' needs 'event': after which one?")
        return self


class Publish(Section):
    """A message to publish."""

    topic: TopicName
    """The topic; it must take messages."""
    value: Any
    """The message: a number, a text, a colour (name, Gazebo material or r, g, b), or its fields."""


def _one_or_more(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


OneOrMore = Annotated[
    tuple[Publish, ...], BeforeValidator(_one_or_more, json_schema_input_type=Publish | tuple[Publish, ...])
]
"""A list, or its single element."""


class Event(Section):
    """An event, which happens once, at a time or by a condition, between two steps."""

    alternatives = ("at", "when")

    at: TimeNs | None = None
    """When: at the first step not before this time."""
    when: When | None = None
    """When: after the first step at whose end this holds."""
    publish: OneOrMore = ()
    """What is published then, one or a list; without it the event is only noted."""


def causes_of(name: str, events: Mapping[str, Event]) -> list[str]:
    """Return the events that an event waits for, the direct predecessor first, without duplicates."""
    causes: list[str] = []
    while name in events:
        when = events[name].when
        if when is None or when.event is None or when.event in causes:
            break
        name = when.event
        causes.append(name)
    return causes


class WithinOf(Section):
    """A time limit after an event."""

    event: Name
    """The event from which time counts."""
    time: DurationNs
    """How long it may take."""


class During(Section):
    """A part of the run."""

    since: TimeOrEvent = START
    """Its first point in time."""
    until: TimeOrEvent = END
    """Its last point in time."""


class StaysWithin(Section):
    """A model does not leave a circle on the ground."""

    model: Name
    """The model whose origin counts."""
    distance: Annotated[LengthM, Field(gt=0)]
    """Radius of the circle."""
    of: Centre = START
    """Its centre: where the model is at the first point in time that counts, or a place."""
    during: During = During()
    """When it counts; by default the whole run."""


class TopicStays(TopicIs):
    """A topic keeps a value."""

    during: During = During()
    """When it counts; by default the whole run."""


class Criterion(Observed):
    """A criterion that the run must meet to pass.

    A condition on an observable holds at each moment of a part of the run, or with ``by`` or ``for`` at least
    once.
    """

    alternatives = ("near", "stays_within", "topic_stays", "observable")

    near: Near | None = None
    """A model comes near something."""
    within_of: WithinOf | None = None
    """A time limit after an event; without it at any time. Goes with ``near``."""
    stays_within: StaysWithin | None = None
    """A model stays where it is."""
    topic_stays: TopicStays | None = None
    """A topic keeps a value."""
    by: TimeOrEvent | None = None
    """The condition holds once until then. Goes with ``observable``."""
    lasting: DurationNs | None = Field(default=None, alias="for")
    """The condition holds for this time without a gap. Goes with ``observable``."""
    during: During | None = None
    """When a condition on an observable counts; by default the whole run."""

    @model_validator(mode="after")
    def _fitting_conditions(self) -> Criterion:
        self._check_bounds()
        if self.within_of is not None and self.near is None:
            raise ValueError("'within_of' goes with 'near'")
        for name, value in (("by", self.by), ("for", self.lasting), ("during", self.during)):
            if value is not None and self.observable is None:
                raise ValueError(f"'{name}' goes with 'observable'")
        if self.by is not None and self.during is not None and self.during.until != END:
            raise ValueError("'by' is the end of the time that counts: leave out 'until'")
        return self

    def periods(self) -> list[tuple[tuple[str, ...], During]]:
        """Return the parts of the run in which it counts, with the keys above them."""
        kinds = (("stays_within", self.stays_within), ("topic_stays", self.topic_stays))
        found: list[tuple[tuple[str, ...], During]] = [
            ((kind,), stays.during) for kind, stays in kinds if stays is not None
        ]
        return found if self.during is None else [((), self.during)]
