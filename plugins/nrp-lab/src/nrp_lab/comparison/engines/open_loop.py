"""Run each engine on exactly the inputs that another one had.

In a closed loop a difference in one signal spreads to all others. So one run of the first two engines is
recorded with its images, and each other engine runs once against the recorded other side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from nrp_core.errors import NrpError
from nrp_core.recording.layout import Images
from nrp_core.recording.reading.recording import Recording
from nrp_core.recording.replay.recorded_world import with_recorded_brain, with_recorded_world
from nrp_lab.comparison.completeness import missing_from
from nrp_lab.comparison.engines.measures import BRAIN, WORLD, EngineMargins, measured
from nrp_lab.comparison.engines.verdict import EngineDifference, EngineVerdict, ranked
from nrp_lab.comparison.grid import GridCell, RunGrid
from nrp_lab.comparison.running import is_whole, record
from nrp_lab.comparison.signals import RunSignals

FOLDER = "engines"
"""Name of the folder of these recordings, within that of the grid's runs."""

Side = Literal["brain", "world"]
_REVISED = {"brain": with_recorded_world, "world": with_recorded_brain}


@dataclass(frozen=True, slots=True)
class Exchange:
    """One engine in the place of another.

    Args:
        side: the exchanged side; the other one is played back.
        cell: the run with the other engine.
    """

    side: Side
    cell: GridCell


def exchanges(grid: RunGrid) -> list[Exchange]:
    """Return every backend in the place of the first of its side, for the first seed."""
    first = _reference(grid)
    brains = [Exchange("brain", GridCell(b, first.world, first.seed)) for b in grid.brains[1:]]
    worlds = [Exchange("world", GridCell(first.brain, w, first.seed)) for w in grid.worlds[1:]]
    return [*brains, *worlds]


def compare_engines(
    grid: RunGrid, results: Path, margins: EngineMargins, tell: Callable[[int, int, str], None]
) -> EngineVerdict:
    """Make the missing runs, and evaluate them.

    Args:
        grid: the grid of runs.
        results: a folder for the recordings; recordings that are in it are kept.
        margins: the margins.
        tell: called with the number of finished runs, the number of all runs, and the last one.

    Raises:
        ExperimentError: a margin was set for a part that no run has.
    """
    first, wanted = _reference(grid), exchanges(grid)
    reference = grid.folder(results / FOLDER, first)
    differences: list[EngineDifference] = []
    problems: list[str] = []
    try:
        if not is_whole(reference):
            record(grid, first, reference, images=Images.EXACT)
        ours = RunSignals(Recording(reference))
        for done, exchange in enumerate(wanted, 1):
            theirs = RunSignals(Recording(_replayed(grid, exchange, reference)))
            problems += _failures(exchange, ours, theirs)
            differences += _differences(exchange, first, ours, theirs, margins)
            tell(done, len(wanted), str(exchange.cell))
    except NrpError as error:  # without playback the engine has no verdict, but the finding has one
        problems.append(str(error))
    margins.require_parts(f"{one.measure.name}/{one.part}" for one in differences)
    return EngineVerdict(ranked(differences), problems)


def _reference(grid: RunGrid) -> GridCell:
    return GridCell(grid.brains[0], grid.worlds[0], grid.seeds[0])


def _replayed(grid: RunGrid, exchange: Exchange, reference: Path) -> Path:
    """Run an engine on the recorded inputs, unless that is recorded."""
    own = grid.folder(reference.parent, exchange.cell)
    digest = reference.name.rpartition("-")[2]
    folder = own.with_name(f"{own.name}-as-{digest}")
    if not is_whole(folder):
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
    exchange: Exchange, first: GridCell, ours: RunSignals, theirs: RunSignals, margins: EngineMargins
) -> list[EngineDifference]:
    end_s = min(ours.end_s, theirs.end_s)
    one, other = (run.between(run.begin_s, end_s) for run in (ours, theirs))
    names = (getattr(cell, exchange.side) for cell in (first, exchange.cell))
    a, b = names
    is_brain = exchange.side == "brain"
    return [
        EngineDifference(
            exchange.side,
            a,
            b,
            apart.measure,
            apart.part,
            apart.amount,
            margins.of(apart.measure, apart.part),
        )
        for apart in measured(one, other, BRAIN if is_brain else WORLD, spikes=is_brain)
    ]
