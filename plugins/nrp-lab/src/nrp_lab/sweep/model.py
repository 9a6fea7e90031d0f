"""The file of a sweep as typed data, with the documentation of its keys, and its reader."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import exp, log
from pathlib import Path
from typing import Annotated, Any, Self, TypeAlias, TypeVar

from pydantic import Field, PlainValidator, WithJsonSchema, field_validator, model_validator

from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Name, Range, Section, Tree, form_of, read_form, read_form_tree
from nrp_core.findings import Code, InvalidExperimentError
from nrp_core.quantities import TIME_UNITS, DurationNs

Value: TypeAlias = "bool | int | float | str | list[Any]"
"""A value of a setting, as in an experiment file."""

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*")
_KEYS = ("from", "to", "steps", "scale")
_SCALES = ("linear", "log")
_DIGITS = 12  # significant digits: enough for any setting, and short in a table


@dataclass(frozen=True, slots=True)
class Choices:
    """A list of values, in any order."""

    levels: tuple[Value, ...]

    def __len__(self) -> int:
        return len(self.levels)

    def at(self, share: float) -> Value:
        """Return the value at a fraction of the list, from 0 up to 1."""
        return self.levels[min(int(share * len(self.levels)), len(self.levels) - 1)]


@dataclass(frozen=True)
class Span:
    """The numbers from one to another.

    Args:
        low, high: the ends; both are included.
        unit: their unit; may be empty.
        steps: number of values in a grid; None: every whole number.
        is_log: whether values are spaced logarithmically.
        is_whole: whether all values are whole numbers.
    """

    low: float
    high: float
    unit: str = ""
    steps: int | None = None
    is_log: bool = False
    is_whole: bool = False

    def __len__(self) -> int:
        if self.steps is not None:
            return self.steps
        return int(self.high - self.low) + 1 if self.is_whole else 0

    @cached_property
    def levels(self) -> tuple[Value, ...]:
        """The values of a grid; empty for a span of real numbers without ``steps``."""
        if self.steps is None:
            return tuple(range(int(self.low), int(self.high) + 1)) if self.is_whole else ()
        gaps = max(self.steps - 1, 1)
        return tuple(self._value(self._number(step / gaps)) for step in range(self.steps))

    def at(self, share: float) -> Value:
        """Return the value at a fraction of the span, from 0 up to 1."""
        if levels := self.levels:
            return Choices(levels).at(share)
        return self._value(self._number(share))

    @property
    def ends(self) -> tuple[Value, Value]:
        """The first and the last value."""
        return self._value(self.low), self._value(self.high)

    def _number(self, share: float) -> float:
        if self.is_log:
            return exp(log(self.low) + share * (log(self.high) - log(self.low)))
        return self.low + share * (self.high - self.low)

    def _value(self, number: float) -> Value:
        number = float(f"{number:.{_DIGITS}g}")
        if self.is_whole:
            return round(number)
        if self.unit in TIME_UNITS:
            number = seconds(round(number * TIME_UNITS[self.unit] * NS_PER_S)) / TIME_UNITS[self.unit]
        return f"{number:.{_DIGITS}g} {self.unit}" if self.unit else number


Axis: TypeAlias = Choices | Span | Range


def axis_of(value: object) -> Axis:
    """Read the values of a setting.

    Raises:
        ValueError: they have another form.
    """
    match value:
        case Choices() | Span() | Range():
            return value
        case Mapping():
            return _span(value)
        case list():
            return _choices(value)
        case str() if ".." in value:
            return Range.parse(value)
    raise ValueError(
        f"expected a list of values, {{from: 0.5, to: 2, steps: 7}}, or a range to draw from with each "
        f"seed, such as 4..8 s; not {value!r}"
    )


def _choices(values: list[Any]) -> Choices:
    if not values:
        raise ValueError("the list of values is empty")
    seen: set[str] = set()
    for value in values:
        if isinstance(value, Mapping) or value is None:
            raise ValueError(f"a value is a number, a string, true, false or a list, not {value!r}")
        if repr(value) in seen:  # 1 and true are equal in Python
            raise ValueError(f"the value {value!r} appears twice")
        seen.add(repr(value))
    return Choices(tuple(values))


def _span(given: Mapping[str, Any]) -> Span:
    for key in given:
        if key not in _KEYS:
            raise ValueError(f"a span has no key '{key}'{did_you_mean(key, _KEYS)}")
    if missing := [key for key in ("from", "to") if key not in given]:
        raise ValueError(f"a span needs '{missing[0]}', as in {{from: 0.5, to: 2, steps: 7}}")
    (low, unit), (high, other) = _quantity(given["from"]), _quantity(given["to"])
    if unit != other:
        raise ValueError(f"both ends need the same unit, not '{given['from']}' and '{given['to']}'")
    if not low < high:
        raise ValueError(f"'to' of a span must be above 'from', not {given['from']} to {given['to']}")
    steps, scale = given.get("steps"), given.get("scale", "linear")
    if steps is not None and (isinstance(steps, bool) or not isinstance(steps, int) or steps < 2):
        raise ValueError(f"'steps' is the number of values, at least 2, not {steps!r}")
    if scale not in _SCALES:
        raise ValueError(f"'scale' is linear or log, not {scale!r}")
    if scale == "log" and low <= 0:
        raise ValueError(f"a logarithmic scale needs values above 0, not {given['from']}")
    ends_whole = all(isinstance(given[key], int) for key in ("from", "to"))
    whole = ends_whole and scale == "linear" and (steps is None or (high - low) % (steps - 1) == 0)
    return Span(low, high, unit, steps, scale == "log", whole)


def _quantity(value: object) -> tuple[float, str]:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value), ""
    if isinstance(value, str) and (found := _QUANTITY.fullmatch(value)):
        return float(found[1]), found[2]
    raise ValueError(f"an end of a span is a number, with or without a unit, not {value!r}")


def written(key: str, value: Value) -> str:
    """Return a setting as an override, ``dotted.key=value``."""
    return f"{key}={value if isinstance(value, str) else json.dumps(value)}"


SEED = "seed"
GRID = "grid"
SAMPLED = ("random", "sobol", "latin")
GIVEN = "given"


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
    """Return a string unchanged, because one from a file carries its folder."""
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


M = TypeVar("M", bound=ManyRuns)


def read_sweep(path: Path) -> tuple[SweepFile, Tree]:
    """Read a file of a sweep; see :func:`read_many_runs`."""
    return read_many_runs(path, SweepFile, "a sweep")


def sweep_of(tree: Tree) -> SweepFile:
    """Return the sweep of a tree; see :func:`~nrp_core.experiment.reading.reader.form_of`."""
    return form_of(tree, SweepFile, "a sweep")


def read_many_runs(path: Path, form: type[M], what: str) -> tuple[M, Tree]:
    """Read a file of many runs; see :func:`~nrp_core.experiment.reading.reader.read_form`.

    Raises:
        ExperimentError: it does not exist, or is a folder.
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    if not path.is_file():
        wrong = "it is a folder" if path.is_dir() else "there is no such file"
        raise ExperimentError(f"{wrong}; {what} is a YAML file", path=path)
    _require_fitting(path, form, what)
    return read_form(path, form, what)


def _require_fitting(path: Path, form: type[ManyRuns], what: str) -> None:
    """Refuse the file of another command, before all the keys that it lacks are listed.

    Raises:
        InvalidExperimentError: it is one.
    """
    tree = read_form_tree(path, what)
    keys, of_search = set(tree.value), {"objective", "population", "generations"}
    if not keys & {"experiment", "vary"} and keys & {"brain", "world", "extends"}:
        message = f"this file is an experiment; {what} names one under 'experiment'"
    elif keys & of_search and not of_search & form.model_fields.keys():
        message = "this file has an objective: use nrp evolve"
    elif not keys & of_search and of_search <= form.model_fields.keys():
        message = "this file has no objective: use nrp sweep"
    else:
        return
    raise InvalidExperimentError([tree.place.finding(Code.NRP201, message)])
