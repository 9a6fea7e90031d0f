"""The file of a search as typed data, with the documentation of its keys, and its reader."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PlainValidator, PositiveInt, WithJsonSchema, model_validator

from nrp_core.experiment import Tree, form_of
from nrp_lab.sweep.model import SEED, Choices, Design, ManyRuns, SweepFile, read_many_runs

Weights = dict[str, float]
"""The factor of each measure, ``metric.part``, in a weighted sum."""


def _objectives(value: object) -> tuple[Weights, ...]:
    given: Iterable[Any] = value if isinstance(value, (list, tuple)) else [value]
    for one in given:
        if not (isinstance(one, Mapping) and one):
            raise ValueError(
                f"an objective is a sum, {{METRIC.PART: WEIGHT}}, or a list of sums, not {one!r}"
            )
        for name, weight in one.items():
            if (
                isinstance(weight, bool)
                or not isinstance(weight, (int, float))
                or not (weight and isfinite(weight))
            ):
                raise ValueError(f"the weight of {name} is a number other than 0, not {weight!r}")
            if not all(str(name).partition(".")[::2]):
                raise ValueError(f"a measure is named METRIC.PART, such as distance.pioneer, not '{name}'")
    return tuple({str(name): float(weight) for name, weight in one.items()} for one in given)


Objectives = Annotated[
    tuple[Weights, ...],
    PlainValidator(_objectives),
    WithJsonSchema({"type": ["object", "array"], "examples": [{"distance.pioneer": 1.0}]}),
]


class EvolveFile(ManyRuns):
    """An experiment, the settings to search with their ranges, and the objective."""

    objective: Objectives
    """The weighted sum of measures to maximise; or a list of several, for an optimiser that can do that."""
    missing: Weights = Field(default_factory=dict)
    """The values of measures that a run does not have, such as the time of an event that did not happen."""
    over_seeds: Literal["mean", "worst"] = "mean"
    """How the values of a candidate's seeds become one."""
    optimiser: str = "cma"
    """Its name."""
    optimiser_seed: int = 1
    """The seed of its random numbers."""
    population: PositiveInt
    """Number of candidates in a generation."""
    generations: PositiveInt
    """The largest number of generations."""
    goal: float | None = None
    """The search ends when a candidate reaches this value."""

    @model_validator(mode="after")
    def _searchable(self) -> Self:
        if not self.sampled:
            raise ValueError("vary: no setting has a range to search, as in {from: 0.5, to: 2}")
        for key in self.sampled:
            if isinstance(self.vary[key], Choices):
                raise ValueError(
                    f"vary.{key}: a search needs a range, as in {{from: 0.5, to: 2, scale: log}}, not a list"
                )
        if self.goal is not None and len(self.objective) > 1:
            raise ValueError("goal: a search with several objectives has no goal")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The measures of all objectives."""
        return tuple(dict.fromkeys(name for one in self.objective for name in one))

    @property
    def seeds(self) -> int:
        """Number of runs of a candidate."""
        return len(self.vary[SEED]) if SEED in self.vary else 1  # type: ignore[arg-type]

    @property
    def search(self) -> dict[str, Any]:
        """The settings that determine the sequence of candidates."""
        names = ("objective", "missing", "over_seeds", "optimiser", "optimiser_seed", "population")
        ranges = {key: str(self.vary[key]) for key in self.vary}
        given = {name: getattr(self, name) for name in names}
        return {**given, "objective": list(self.objective), "seeds": self.seeds, "ranges": ranges}

    def as_sweep(self) -> SweepFile:
        """Return the sweep that makes the runs, as yet without points."""
        metrics = dict.fromkeys((*self.measure, *(name.partition(".")[0] for name in self.names)))
        shared = {name: getattr(self, name) for name in ManyRuns.model_fields}
        return SweepFile.model_construct(**{**shared, "measure": tuple(metrics), "design": Design.given(())})


def read_evolve(path: Path) -> tuple[EvolveFile, Tree]:
    """Read a file of a search.

    Returns:
        the search, and the file with the place of every value.

    Raises:
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    return read_many_runs(path, EvolveFile, "a search")


def evolve_of(tree: Tree) -> EvolveFile:
    """Return the search of a tree.

    Raises:
        InvalidExperimentError: it is not valid; the error carries all findings.
    """
    return form_of(tree, EvolveFile, "a search")
