"""The result of a comparison as data: of a grid of runs, or of two recordings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from nrp_core.errors import ExperimentError
from nrp_core.recording import Recording
from nrp_lab.comparison.divergence import Deviation, Divergence, deviations, divergence_of
from nrp_lab.comparison.engine_measures import differences
from nrp_lab.comparison.engine_verdict import NOT_COMPARED, EngineVerdict, ranked
from nrp_lab.comparison.grid import GridCell, RunGrid
from nrp_lab.comparison.judgement import Answer, Judgement, Relation, combined, controls_of
from nrp_lab.comparison.measuring import judge
from nrp_lab.comparison.metric import DistanceMetric, Margins, Metric, ScalarMetric
from nrp_lab.comparison.shipped_metrics import ObservableValues, observables_of
from nrp_lab.comparison.signals import RunSignals, incompleteness, missing_from


@dataclass(frozen=True)
class GridDiff:
    """The result of running one experiment on several backends, or with several wirings.

    Args:
        name: name of the experiment.
        grid: the grid of runs.
        runs: every run.
        judgements: the judgement of every metric, those of the finding first.
        divergences: where the runs of the first seed diverge, for each backend against its side's first.
        folder: the folder of the recordings.
        engines: the verdict on the engines, each on the inputs of another.
    """

    name: str
    grid: RunGrid
    runs: Mapping[GridCell, RunSignals]
    judgements: Sequence[Judgement]
    divergences: Sequence[Divergence]
    folder: Path
    engines: EngineVerdict = NOT_COMPARED

    @classmethod
    def of(
        cls, grid: RunGrid, runs: Mapping[GridCell, RunSignals], metrics: Sequence[Metric], margins: Margins,
        folder: Path, engines: EngineVerdict = NOT_COMPARED,
    ) -> GridDiff:  # fmt: skip
        """Measure, judge, and find where runs diverge."""
        name = str(next(iter(runs.values())).settings.get("name", grid.experiment))
        metrics = [*metrics, *observables_of(runs.values())]
        return cls(
            name, grid, runs, judge(grid, runs, metrics, margins), _divergences(grid, runs), folder, engines
        )

    @cached_property
    def finding(self) -> Sequence[Judgement]:
        """The metrics of the finding; all metrics if the experiment has no criteria and no events."""
        measured = [one for one in self.judgements if one.answer is not Answer.NONE]
        return [one for one in measured if one.metric.is_finding] or measured

    @property
    def answer(self) -> Answer:
        """The factors that the finding depends on."""
        return combined(one.answer for one in self.finding)

    @property
    def controls(self) -> dict[str, Relation]:
        """The relation of each control to the original, over all parts of the finding."""
        return controls_of(self.finding)

    @property
    def failures(self) -> dict[GridCell, str]:
        """The runs that failed, with the reasons."""
        missing = {cell: missing_from(run) for cell, run in self.runs.items()}
        return {cell: reasons for cell, reasons in missing.items() if reasons}

    @property
    def incomplete(self) -> list[str]:
        """The runs that lack parts or ended early, with the reasons."""
        return incompleteness({str(cell): run for cell, run in self.runs.items()})


def _divergences(grid: RunGrid, runs: Mapping[GridCell, RunSignals]) -> list[Divergence]:
    """Compare every backend with the first one of its side, and every control, for the first seed."""
    if grid.decoders or grid.others:
        return []
    seed, (brain, *brains), (world, *worlds) = grid.seeds[0], grid.brains, grid.worlds
    own, *others = grid.variants
    pairs = [(GridCell(brain, w, seed, own), GridCell(b, w, seed, own)) for b in brains for w in grid.worlds]
    pairs += [(GridCell(b, world, seed, own), GridCell(b, w, seed, own)) for w in worlds for b in grid.brains]
    if not grid.timesteps:  # steps of runs with different ones cannot be compared
        pairs += [
            (GridCell(brain, world, seed, own), GridCell(brain, world, seed, control)) for control in others
        ]
    return [divergence_of(runs[one], runs[other]) for one, other in pairs]


@dataclass(frozen=True, slots=True)
class Measured:
    """A part of a metric in two runs.

    Args:
        metric: the metric.
        part: one of its parts.
        one, other: the values, for metrics that are numbers.
        apart: their difference, or the distance.
    """

    metric: Metric
    part: str
    one: float | None
    other: float | None
    apart: float | None


@dataclass(frozen=True)
class PairDiff:
    """The common part of two recordings and their divergence, over the time that both cover.

    Args:
        one, other: the runs, over the time that both cover.
        divergence: where they diverge.
        deviations: the differences of the signals.
        measured: every part of every metric.
        engines: the verdict on the engines. The inputs of both are their own, so that a difference may follow
            from another one.
        reservations: the parts of the runs that are not compared, with the reasons.
        flaws: the damaged files of the recordings.
    """

    one: RunSignals
    other: RunSignals
    divergence: Divergence
    deviations: Sequence[Deviation]
    measured: Sequence[Measured]
    engines: EngineVerdict = NOT_COMPARED
    reservations: Sequence[str] = ()
    flaws: Sequence[str] = ()

    @classmethod
    def of(
        cls, one: Path, other: Path, metrics: Sequence[Metric], margins: Margins | None = None
    ) -> PairDiff:
        """Compare two recordings, damaged ones as far as they can be read.

        Raises:
            ExperimentError: one is not a recording, or they have no step in common.
        """
        runs = RunSignals(Recording(one)), RunSignals(Recording(other))
        begin_s, end_s = max(run.begin_s for run in runs), min(run.end_s for run in runs)
        ours, theirs = (run.between(begin_s, end_s) for run in runs)
        divergence = divergence_of(ours, theirs)
        flaws = [f"{path}: {flaw}" for path in (one, other) for flaw in Recording(path).check().flaws]
        if not divergence.steps or end_s <= begin_s:
            because = "".join(f"; {flaw}" for flaw in flaws)
            raise ExperimentError(f"has no step in common with {other}{because}", path=one)
        whole = [one for one in metrics if type(one) is not ObservableValues]
        measures = [*whole, *observables_of((ours, theirs))]
        rows = [row for metric in measures for row in _measured(metric, ours, theirs)]
        left_out = [
            *_unlike(ours, theirs),
            *_left_out(one, runs[0], ours),
            *_left_out(other, runs[1], ours),
        ]
        engines = _engines(ours, theirs, margins or Margins())
        return cls(ours, theirs, divergence, deviations(ours, theirs), rows, engines, left_out, flaws)

    @property
    def is_identical(self) -> bool:
        """Whether all common steps are identical, bit for bit, and both recordings are undamaged."""
        return self.divergence.is_identical and not self.flaws

    @property
    def incomplete(self) -> list[str]:
        """The runs that lack parts or ended early, with the reasons."""
        return incompleteness({str(run.recording.folder): run for run in (self.one, self.other)})


def _engines(one: RunSignals, other: RunSignals, margins: Margins) -> EngineVerdict:
    """Measure everything that both runs have."""
    found = differences(one, other, "run", (one.label, other.label), margins)
    margins.require_parts(f"{one.measure.name}/{one.part}" for one in found)
    return EngineVerdict(ranked(found))


def _unlike(one: RunSignals, other: RunSignals) -> Iterator[str]:
    """Describe the groups of neurons that have one name in both runs and are not of one size."""
    for part, (ours, theirs) in _resized(one, other).items():
        yield f"'{part}' has {ours} neurons in one and {theirs} in the other: their trains are not compared"


def _resized(one: RunSignals, other: RunSignals) -> dict[str, tuple[int, int]]:
    """Return the numbers of neurons of the groups that have as many in one run alone."""
    common = [name for name in one.groups if name in other.groups]
    sizes = {name: (len(one.trains_s(name)), len(other.trains_s(name))) for name in common}
    return {name: pair for name, pair in sizes.items() if pair[0] != pair[1]}


def _left_out(path: Path, run: RunSignals, compared: RunSignals) -> Iterator[str]:
    """Describe the part of a recording that is not compared."""
    if not run.recording.complete:
        yield f"{path} is truncated or damaged: only its intact part is compared"
    if (run.begin_s, run.end_s) != (compared.begin_s, compared.end_s):
        yield (
            f"compared from {compared.begin_s:g} s to {compared.end_s:g} s; "
            f"{path} goes from {run.begin_s:g} s to {run.end_s:g} s"
        )


def _measured(metric: Metric, one: RunSignals, other: RunSignals) -> list[Measured]:
    if isinstance(metric, ScalarMetric):
        a, b = metric.values(one), metric.values(other)
        return [
            Measured(metric, part, a.get(part), b.get(part), _difference(a.get(part), b.get(part)))
            for part in dict.fromkeys((*a, *b))
        ]
    assert isinstance(metric, DistanceMetric)
    resized = _resized(one, other)
    ours, theirs = metric.features(one), metric.features(other)
    return [
        Measured(metric, part, None, None, metric.distance(ours[part], theirs[part]))
        for part in ours
        if part in theirs and part not in resized
    ]


def _difference(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else other - one
