"""All runs of a sweep, designed from its axes and checked before the first one begins."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from math import prod
from pathlib import Path
from typing import Any
from warnings import catch_warnings, filterwarnings

import numpy as np

from nrp_core import brains, worlds
from nrp_core.brain import FloatArray
from nrp_core.checks.warnings import announcement, experiment_warnings
from nrp_core.clock import milliseconds, seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import (
    SHIPPED,
    Collector,
    Experiment,
    Key,
    Range,
    Tree,
    code_of,
    find_file,
    load_experiment,
    with_parameters,
)
from nrp_core.findings import Code, InvalidExperimentError
from nrp_core.paths import TextFrom
from nrp_core.registry import Registry
from nrp_core.seeds import Seeds
from nrp_lab.comparison.grid import require_there
from nrp_lab.sweep.measuring import scalar_metric
from nrp_lab.sweep.model import GIVEN, GRID, SEED, Axis, Choices, Design, Span, SweepFile, Value, written
from nrp_lab.sweep.record import Task


def number_of_runs(sweep: SweepFile) -> int:
    """Return the number of runs without making them."""
    seeds = _length(sweep.vary[SEED]) if SEED in sweep.vary else 1
    if sweep.design.kind != GRID:
        return sweep.design.points * seeds
    return prod(_length(sweep.vary[key]) for key in sweep.sampled) * seeds


def _length(axis: Axis) -> int:
    return 1 if isinstance(axis, Range) else len(axis)


def combinations(sweep: SweepFile, own_seed: int) -> Iterator[dict[str, Value]]:
    """Yield the values of every run; runs that differ only in the seed follow each other.

    Args:
        sweep: the sweep.
        own_seed: the seed of the experiment, for a sweep without seeds.
    """
    axes = {key: sweep.vary[key] for key in sweep.sampled}
    seeds: Sequence[Any] = sweep.vary[SEED].levels if SEED in sweep.vary else [own_seed]  # type: ignore[union-attr]
    for point in _points(axes, sweep.design):
        for seed in seeds:
            drawn = {
                key: axis.override(key, seed).partition("=")[2]
                for key, axis in sweep.vary.items()
                if isinstance(axis, Range)
            }
            given = {**point, **drawn, SEED: seed}
            yield {key: given[key] for key in sweep.vary}


def _points(axes: Mapping[str, Axis], design: Design) -> Iterator[dict[str, Value]]:
    if design.kind == GRID:
        levels = [axis.levels for axis in axes.values()]  # type: ignore[union-attr]
        yield from (dict(zip(axes, point, strict=True)) for point in product(*levels))
        return
    for shares in _shares(design, len(axes)).tolist():
        yield {
            key: axis.at(share)  # type: ignore[union-attr]
            for (key, axis), share in zip(axes.items(), shares, strict=True)
        }


def _shares(design: Design, dimensions: int) -> FloatArray:
    """Return points of the unit cube, shape ``(points, dimensions)``; the same for equal designs."""
    if design.kind == GIVEN:
        return np.array(design.shares)
    rng = np.random.default_rng(Seeds(0).child("sweep").integer(design.kind))
    if design.kind == "random":
        return rng.random((design.points, dimensions))
    from scipy.stats import qmc

    make = {"sobol": qmc.Sobol, "latin": qmc.LatinHypercube}[design.kind]
    with _any_number_of_points():
        shares: FloatArray = make(dimensions, rng=rng).random(design.points)
    return shares


@contextmanager
def _any_number_of_points() -> Iterator[None]:
    """Accept a number of Sobol points that is not a power of 2; then the sample is slightly less even."""
    with catch_warnings():
        filterwarnings("ignore", message="The balance properties", category=UserWarning)
        yield


class Mistakes(Collector):
    """Collects errors, those of the experiment as well, with their places in a file that varies it."""

    @contextmanager
    def at(self, *keys: Key) -> Iterator[None]:
        """Collect the error of a block; findings without a place get the place of these keys."""
        with self.during(Code.NRP202, *keys):
            try:
                yield
            except InvalidExperimentError as error:
                self.place((one for one in error.findings if one not in self.findings), *keys)


MOST_RUNS = 100_000
"""The largest number of runs that needs no confirmation."""
_BACKENDS: Mapping[str, Callable[[], Registry[Any]]] = {"brain.backend": brains, "world.backend": worlds}
_MAX_CHECKED = 20


@dataclass(frozen=True)
class PlannedRun:
    """One run.

    Args:
        task: the task for a worker.
        values: the values of the varying settings, by key.
    """

    task: Task
    values: Mapping[str, Value]


@dataclass(frozen=True)
class Plan:
    """A checked sweep.

    Args:
        sweep: the sweep.
        experiment: a shipped experiment, or the absolute path of a file or folder.
        name: the experiment's own name.
        own_seed: its seed.
        code: fingerprints of the packages that compute the runs.
        search: the settings of the search that chooses the points, if one does.
        parts: the measures that the runs will have, ``metric.part``, by metric; None: known after a run.
    """

    sweep: SweepFile
    experiment: str
    name: str
    own_seed: int
    code: Mapping[str, str] = field(default_factory=dict)
    search: Mapping[str, Any] = field(default_factory=dict)
    parts: Mapping[str, list[str] | None] = field(default_factory=dict)

    @classmethod
    def of(cls, sweep: SweepFile, source: Tree | None = None, *, confirmed: bool = False) -> Plan:
        """Check a sweep and plan its runs.

        Args:
            sweep: the sweep.
            source: its file, for the places of errors.
            confirmed: whether more than :data:`MOST_RUNS` runs are allowed.

        Raises:
            InvalidExperimentError: the experiment, a key, a value or a metric is not valid.
            BackendError: a backend is missing.
            ExperimentError: the sweep has too many runs.
        """
        source = source or Tree({})
        total = number_of_runs(sweep)
        if total > MOST_RUNS and not confirmed:
            raise ExperimentError(
                f"the sweep has {total:,} runs; more than {MOST_RUNS:,} need a confirmation (--yes)",
                path=source.place.path,
            )
        mistakes = Mistakes(source)
        settings = [written(key, _absolute(value)) for key, value in sweep.settings.items()]
        with mistakes.at("experiment"):
            name = _located(sweep.experiment)
        mistakes.raise_errors()
        with mistakes.at("settings" if sweep.settings else "experiment"):
            own = load_experiment(name, settings)
        mistakes.raise_errors()
        _check(sweep, name, settings, own, mistakes)
        backends = [_names(sweep, key, own) for key in _BACKENDS]
        code: dict[str, str] = {}
        for brain in backends[0]:
            for world in backends[1]:
                code |= code_of(brain, world)
        parts = {metric: _parts(metric, own) for metric in sweep.measure}
        return cls(sweep, name, own.name, own.seed, code, parts=parts)

    def __len__(self) -> int:
        return number_of_runs(self.sweep)

    def report_warnings(self, report: Callable[[str], None]) -> None:
        """Report warnings about the experiment without what varies, each once."""
        settings = [written(key, _absolute(value)) for key, value in self.sweep.settings.items()]
        until_s = None if self.sweep.until is None else seconds(self.sweep.until)
        found = experiment_warnings(partial(load_experiment, self.experiment, settings), until_s)
        if text := announcement(self.name, found):
            report(text)

    @cached_property
    def runs(self) -> list[PlannedRun]:
        """All runs in the order of the table."""
        return [
            self._run(index, values) for index, values in enumerate(combinations(self.sweep, self.own_seed))
        ]

    @property
    def identity(self) -> dict[str, Any]:
        """The settings that all runs of one folder share."""
        return {
            "experiment": self.name,
            "settings": {key: written(key, _absolute(value)) for key, value in self.sweep.settings.items()},
            "vary": sorted(self.sweep.vary),
            "measure": list(self.sweep.measure),
            "until_ns": self.sweep.until,
            "stop_when_failed": sorted(self.sweep.stop_when_failed),
            "search": dict(self.search),
        }

    def with_points(self, shares: Iterable[Iterable[float]]) -> Plan:
        """Return the same plan for given points of the unit cube of the settings that vary."""
        return replace(self, sweep=self.sweep.model_copy(update={"design": Design.given(shares)}))

    def _run(self, index: int, values: Mapping[str, Value]) -> PlannedRun:
        given = {SEED: self.own_seed, **self.sweep.settings, **values}
        overrides = (*(written(key, _absolute(value)) for key, value in given.items()), "pace=max")
        described = json.dumps([self._digest, *sorted(overrides)])
        until_ns = self.sweep.until
        task = Task(
            hashlib.blake2b(described.encode(), digest_size=8).hexdigest(), index, self.experiment, overrides,
            self.sweep.measure, None if until_ns is None else seconds(until_ns),
            self.sweep.stop_when_failed, self.code,
        )  # fmt: skip
        return PlannedRun(task, values)

    @cached_property
    def _digest(self) -> str:
        return hashlib.blake2b(json.dumps(self.identity).encode(), digest_size=16).hexdigest()


def _located(experiment: str) -> str:
    """Return the name of a shipped experiment, or the absolute path of another one."""
    folder = experiment.folder if isinstance(experiment, TextFrom) else Path.cwd()
    found = find_file(experiment, folder)
    return str(experiment) if experiment.partition("/")[0] in SHIPPED.names() else str(found)


def _absolute(value: Value) -> Value:
    """Return the absolute path of a file beside the sweep; any other value unchanged."""
    if isinstance(value, TextFrom) and Path(value).suffix and (value.folder / value).is_file():
        return str((value.folder / value).resolve())
    return value


def _check(sweep: SweepFile, name: str, settings: list[str], own: Experiment, mistakes: Mistakes) -> None:
    """Check a sweep's statements about an experiment.

    Raises:
        BackendError: a backend is missing.
        InvalidExperimentError: anything else is wrong; the error carries all findings.
    """
    for metric in sweep.measure:
        with mistakes.at("measure"):
            scalar_metric(metric)
    for key, axis in sweep.vary.items():
        with mistakes.at("vary", key):
            require_there(own, key)
            _require_valid(name, settings, key, axis)
    for place, criterion in enumerate(sweep.stop_when_failed):
        with mistakes.at("stop_when_failed", place):
            _require_criterion(own, criterion)
    for key, registry in _BACKENDS.items():
        section = next((part for part in ("vary", "settings") if key in getattr(sweep, part)), "experiment")
        with mistakes.at(section, key):
            for backend in _names(sweep, key, own):
                registry().provider(backend)
    mistakes.raise_errors()
    if sweep.until is not None and own.strict and "timestep" not in sweep.vary and sweep.until % own.timestep:
        with mistakes.at("until"):
            end, step = f"{seconds(sweep.until):g} s", f"{milliseconds(own.timestep):g} ms"
            raise ExperimentError(f"until: {end} is not a whole number of steps of {step}")
    mistakes.raise_errors()


def _require_valid(experiment: str, settings: list[str], key: str, axis: Axis) -> None:
    for value in _samples(key, axis):
        own = load_experiment(experiment, [*settings, written(key, _absolute(value))])
        collector = Collector(own.source)
        with_parameters(own, collector)
        collector.raise_errors()


def _parts(metric: str, own: Experiment) -> list[str] | None:
    parts = scalar_metric(metric).parts(own)
    return None if parts is None else [f"{metric}.{part}" for part in parts]


def _require_criterion(own: Experiment, name: str) -> None:
    if name not in own.criteria:
        raise ExperimentError(f"there is no criterion '{name}'{did_you_mean(name, own.criteria)}")


def _samples(key: str, axis: Axis) -> Iterator[Value]:
    """Yield the values of an axis to check: all values of a short list, the ends of other axes."""
    match axis:
        case Choices():
            yield from axis.levels[:_MAX_CHECKED]
        case Span():
            yield from axis.ends
        case Range():
            yield axis.override(key, 0).partition("=")[2]


def _names(sweep: SweepFile, key: str, own: Experiment) -> list[str]:
    axis = sweep.vary.get(key)
    if isinstance(axis, Choices):
        return [str(name) for name in axis.levels]
    return [own.brain.backend if key == "brain.backend" else own.world.backend]
