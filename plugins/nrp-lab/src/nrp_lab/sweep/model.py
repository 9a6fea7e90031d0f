"""The file of a sweep as typed data, with the documentation of its keys."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self

from pydantic import Field, PlainValidator, WithJsonSchema, field_validator, model_validator

from nrp_core.errors import did_you_mean
from nrp_core.experiment.model.ranges import Range
from nrp_core.experiment.model.section import Name, Section
from nrp_core.quantities import DurationNs
from nrp_lab.sweep.axes import Axis, Span, axis_of

SEED = "seed"
GRID = "grid"
SAMPLED = ("random", "sobol", "latin")
GIVEN = "given"
_PARTS = 2


@dataclass(frozen=True, slots=True)
class Design:
    """The combinations of values to run.

    Args:
        kind: ``grid``, one of :data:`SAMPLED`, or :data:`GIVEN` by a search.
        points: number of combinations of a sampled design; each is run with every seed.
        shares: the points of a given design, in the unit cube.
    """

    kind: str = GRID
    points: int = 0
    shares: tuple[tuple[float, ...], ...] = ()

    @classmethod
    def given(cls, shares: Iterable[Iterable[float]]) -> Design:
        """Return the design of these points of the unit cube."""
        points = tuple(map(tuple, shares))
        return cls(GIVEN, len(points), points)

    def __str__(self) -> str:
        return self.kind if self.kind == GRID else f"{self.kind} {self.points}"


def _design(value: object) -> Design:
    if isinstance(value, Design):
        return value
    if value == GRID:
        return Design()
    if isinstance(value, Mapping) and len(value) == 1:
        ((kind, points),) = value.items()
        if kind not in SAMPLED:
            raise ValueError(f"there is no design '{kind}'{did_you_mean(str(kind), (GRID, *SAMPLED))}")
        if isinstance(points, int) and not isinstance(points, bool) and points > 0:
            return Design(str(kind), points)
    raise ValueError(f"a design is grid, {{random: 200}}, {{sobol: 256}} or {{latin: 100}}, not {value!r}")


AxisField = Annotated[
    Axis,
    PlainValidator(axis_of),
    WithJsonSchema({
        "type": ["array", "object", "string"],
        "examples": [[0.25, 1], {"from": 0.5, "to": 2, "steps": 7}, "4..8 s"],
    }),
]  # fmt: skip
DesignField = Annotated[
    Design,
    PlainValidator(_design),
    WithJsonSchema({"type": ["string", "object"], "examples": [GRID, {"sobol": 256}]}),
]


def _text(value: object) -> str:
    """Return a string unchanged, because one from a file knows its folder."""
    if not isinstance(value, str):
        raise ValueError(f"the name of an experiment is a string, not {value!r}")
    return value


ExperimentField = Annotated[str, PlainValidator(_text), WithJsonSchema({"type": "string"})]


class ManyRuns(Section):
    """An experiment, the settings that vary, and the measures: the keys that all files of many runs share."""

    experiment: ExperimentField
    """A shipped experiment, or a file or folder, relative to this file."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Settings of every run, by their dotted keys."""
    vary: dict[str, AxisField] = Field(default_factory=dict)
    """The values of the settings that vary, by dotted key."""
    measure: tuple[str, ...] = ("criteria", "time_to_event")
    """Metrics, as in ``nrp diff``, that give a number for each run."""
    until: DurationNs | None = None
    """Simulated time at which every run stops; by default the duration of the experiment."""
    stop_when_failed: tuple[Name, ...] = ()
    """Criteria; a run stops as soon as one of them is not met."""

    @field_validator("settings")
    @classmethod
    def _plain(cls, settings: dict[str, Any]) -> dict[str, Any]:
        for key, value in settings.items():
            if isinstance(value, Mapping) or value is None:
                raise ValueError(f"a setting is one value with a dotted key, such as '{key}.name: 1'")
        return settings

    @field_validator("measure", "stop_when_failed")
    @classmethod
    def _once(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for place, name in enumerate(names):
            if name in names[:place]:
                raise ValueError(f"'{name}' is named twice")
        return names

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        for key in self.vary:
            if key in self.settings:
                raise ValueError(f"'{key}' appears under both 'settings' and 'vary'")
        if isinstance(seeds := self.vary.get(SEED), Range):
            raise ValueError("vary.seed: seeds cannot be drawn; write {from: 1, to: 10}, or a list")
        if isinstance(seeds, Span):
            require_steps(SEED, seeds)
        return self

    @property
    def sampled(self) -> list[str]:
        """The keys whose values a design combines: all but the seed and the settings drawn with it."""
        return [key for key, axis in self.vary.items() if key != SEED and not isinstance(axis, Range)]


class SweepFile(ManyRuns):
    """Many runs by a design."""

    design: DesignField = Design()
    """The combinations of values to run."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key in self.sampled if self.design.kind == GRID else ():
            require_steps(key, self.vary[key])
        if self.design.kind != GRID and not self.sampled:
            raise ValueError(f"design: no setting varies that {self.design.kind} could sample")
        return self


def require_steps(key: str, axis: Axis) -> None:
    """Refuse a span of real numbers where its values are counted.

    Raises:
        ValueError: it is one.
    """
    if isinstance(axis, Span) and not len(axis):
        raise ValueError(f"vary.{key}: a grid of numbers needs 'steps', as in {{from: 0.5, to: 2, steps: 7}}")
