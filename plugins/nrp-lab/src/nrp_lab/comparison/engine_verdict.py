"""The verdict on two engines, its baseline of known differences, and runs with recorded inputs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import groupby
from math import inf, isfinite
from pathlib import Path
from typing import Literal

from nrp_core.errors import ExperimentError, NrpError
from nrp_core.recording import Images, Recording, with_recorded_brain, with_recorded_world
from nrp_core.utilities import join_with_limit, replace_file, strict_json
from nrp_lab.comparison.engine_measures import EngineDifference, differences
from nrp_lab.comparison.grid import GridCell, RunGrid, is_reusable, record
from nrp_lab.comparison.metric import Margins
from nrp_lab.comparison.signals import RunSignals, missing_from

_MAX_NAMED = 4


class Agreement(StrEnum):
    """The verdict on the engines."""

    AGREE = "the engines agree"
    KNOWN = "the engines differ as known"
    DIFFER = "the engines differ"
    NONE = "the engines were not compared"


@dataclass(frozen=True)
class EngineVerdict:
    """The engines compared.

    Args:
        differences: every part of every measure, the largest in units of its margin first.
        problems: the reasons why the comparison is incomplete, such as an engine that failed.
    """

    differences: Sequence[EngineDifference]
    problems: Sequence[str] = ()

    @property
    def new(self) -> list[EngineDifference]:
        """The differences that matter and are not in a baseline."""
        return [one for one in self.differences if one.matters and not one.is_known]

    @property
    def known(self) -> list[EngineDifference]:
        """The differences that matter and are in a baseline."""
        return [one for one in self.differences if one.matters and one.is_known]

    @property
    def agreement(self) -> Agreement:
        """The verdict."""
        if self.new:
            return Agreement.DIFFER
        if self.problems or not self.differences:
            return Agreement.NONE
        return Agreement.KNOWN if self.known else Agreement.AGREE

    @property
    def agrees(self) -> bool:
        """Whether the engines agree except for known differences."""
        return self.agreement in (Agreement.AGREE, Agreement.KNOWN)

    @property
    def headline(self) -> str:
        """The verdict in a sentence that names the largest differences."""
        both = "runs" if all(one.one == one.other for one in self.differences) else "engines"
        match self.agreement:
            case Agreement.DIFFER:
                partly = (
                    f"Not compared to the end ({'; '.join(self.problems)}): the" if self.problems else "The"
                )
                return f"{partly} {both} differ in {_named(self.new)}"
            case Agreement.NONE:
                reasons = "; ".join(self.problems) or "they have no common signals"
                return f"The engines were not compared: {reasons}"
            case Agreement.KNOWN:
                return f"The {both} agree, apart from {len(self.known)} known differences"
            case _:
                return f"The {both} agree: {len(self.differences)} measurements are within their margins"


NOT_COMPARED = EngineVerdict(())
"""The verdict where nothing was measured."""


def ranked(differences: Sequence[EngineDifference]) -> list[EngineDifference]:
    """Return differences, the largest in units of its margin first."""
    return sorted(differences, key=lambda one: -one.size)


def _named(differences: Sequence[EngineDifference]) -> str:
    """Name the worst part of each measure between two engines, the largest first."""

    def title(one: EngineDifference) -> tuple[str, str, str, str]:
        return one.side, one.one, one.other, one.measure.name

    groups = [next(iter(group)) for _, group in groupby(sorted(differences, key=title), title)]
    worst = ranked(groups)
    names = [
        f"{one.measure.title} ({one.side} {one.one} -> {one.other}, {one.part}: {one.effect})"
        for one in worst
    ]
    return join_with_limit(names, _MAX_NAMED, "; ")


_GROWTH = 0.25
"""A known difference may become larger by this share."""


def _amount(value: object) -> float:
    """Return an amount in a file.

    Raises:
        ValueError: it is neither a number nor null.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, type(None))):
        raise ValueError(f"an amount is a number or null, not {value!r}")
    return inf if value is None else float(value)


@dataclass(frozen=True, slots=True)
class Baseline:
    """The known differences of one experiment.

    Args:
        experiment: its name.
        known: amount by the key of the difference; infinite where one engine has no such signal.
    """

    experiment: str
    known: Mapping[str, float]

    @classmethod
    def of(cls, experiment: str, differences: Sequence[EngineDifference]) -> Baseline:
        """Return the baseline with all differences that matter."""
        return cls(experiment, {one.key: one.amount for one in differences if one.matters})

    @classmethod
    def read(cls, path: Path, experiment: str | None = None) -> Baseline:
        """Read a baseline.

        Raises:
            ExperimentError: the file is not one, or is one of another experiment.
        """
        try:
            data = strict_json(path.read_text("utf-8"))
            found = cls(str(data["experiment"]), {str(k): _amount(v) for k, v in data["known"].items()})
            if surplus := data.keys() - {"experiment", "known"}:
                raise ValueError(f"it has no key '{min(surplus)}'")
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            why = f" ({error})" if isinstance(error, ValueError) else ""
            needed = "it needs 'experiment' and 'known', as nrp diff --baseline writes them"
            raise ExperimentError(f"is not a baseline: {needed}{why}", path=path) from error
        if experiment is not None and found.experiment != experiment:
            raise ExperimentError(
                f"is the baseline of '{found.experiment}', not of '{experiment}'; give another file",
                path=path,
            )
        return found

    def write(self, path: Path) -> None:
        """Write it as JSON.

        Raises:
            ExperimentError: the file cannot be written.
        """
        known = {key: amount if isfinite(amount) else None for key, amount in sorted(self.known.items())}
        data = {"experiment": self.experiment, "known": known}
        replace_file(path, json.dumps(data, indent=1) + "\n")

    def applied(self, verdict: EngineVerdict) -> EngineVerdict:
        """Return a verdict in which the known differences are marked."""
        return replace(
            verdict, differences=[replace(one, is_known=self._has(one)) for one in verdict.differences]
        )

    def _has(self, one: EngineDifference) -> bool:
        known = self.known.get(one.key)
        if known is None or known * one.amount < 0:
            return False
        return abs(one.amount) <= max(abs(known) * (1 + _GROWTH), abs(known) + one.margin / 2)


FOLDER = "engines"
"""Name of the folder of these recordings, within that of the grid's runs."""

Side = Literal["brain", "world"]
_REVISED = {"brain": with_recorded_world, "world": with_recorded_brain}


@dataclass(frozen=True, slots=True)
class Exchange:
    """The exchange of one engine for another.

    Args:
        side: the exchanged side; the other one is played back.
        cell: the run with the other engine.
    """

    side: Side
    cell: GridCell


def exchanges(grid: RunGrid) -> list[Exchange]:
    """Exchange the first backend of each side for every other one, for the first seed."""
    first = _reference(grid)
    brains = [Exchange("brain", GridCell(b, first.world, first.seed)) for b in grid.brains[1:]]
    worlds = [Exchange("world", GridCell(first.brain, w, first.seed)) for w in grid.worlds[1:]]
    return [*brains, *worlds]


def compare_engines(
    grid: RunGrid, results: Path, margins: Margins, on_progress: Callable[[int, int, str], None]
) -> EngineVerdict:
    """Make the missing runs, and evaluate them.

    Args:
        grid: the grid of runs.
        results: a folder for the recordings; recordings that are in it are kept.
        margins: the margins.
        on_progress: called with the number of finished runs, the number of all runs, and the last one.

    Raises:
        ExperimentError: a margin was set for a part that no run has.
    """
    first, wanted = _reference(grid), exchanges(grid)
    reference = grid.folder(results / FOLDER, first)
    found: list[EngineDifference] = []
    problems: list[str] = []
    try:
        if not is_reusable(reference, grid.file):
            record(grid, first, reference, images=Images.EXACT)
        ours = RunSignals(Recording(reference))
        for done, exchange in enumerate(wanted, 1):
            theirs = RunSignals(Recording(_replayed(grid, exchange, reference)))
            problems += _failures(exchange, ours, theirs)
            found += _differences(exchange, first, ours, theirs, margins)
            on_progress(done, len(wanted), str(exchange.cell))
    except NrpError as error:  # without playback the engine has no verdict, but the finding has one
        problems.append(str(error))
    margins.require_parts(f"{one.measure.name}/{one.part}" for one in found)
    return EngineVerdict(ranked(found), problems)


def _reference(grid: RunGrid) -> GridCell:
    return GridCell(grid.brains[0], grid.worlds[0], grid.seeds[0])


def _replayed(grid: RunGrid, exchange: Exchange, reference: Path) -> Path:
    """Run an engine on the recorded inputs, unless that is recorded."""
    own = grid.folder(reference.parent, exchange.cell)
    digest = reference.name.rpartition("-")[2]
    folder = own.with_name(f"{own.name}-as-{digest}")
    if not is_reusable(folder, grid.file):
        source = Recording(reference)
        revise = _REVISED[exchange.side]
        images = Images.EXACT if exchange.side == "world" else Images.OFF
        record(grid, exchange.cell, folder, images=images, revise=lambda plan: revise(plan, source))
    return folder


def _failures(exchange: Exchange, *runs: RunSignals) -> Iterator[str]:
    for run in runs:
        if reason := missing_from(run):
            yield f"{exchange.cell} on recorded inputs: {reason}"


def _differences(
    exchange: Exchange, first: GridCell, ours: RunSignals, theirs: RunSignals, margins: Margins
) -> list[EngineDifference]:
    end_s = min(ours.end_s, theirs.end_s)
    one, other = (run.between(run.begin_s, end_s) for run in (ours, theirs))
    names = getattr(first, exchange.side), getattr(exchange.cell, exchange.side)
    return differences(one, other, exchange.side, names, margins)
