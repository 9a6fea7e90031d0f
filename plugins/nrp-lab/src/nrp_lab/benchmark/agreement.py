"""Whether backends agree on a task: the verdict of ``nrp diff``, from the rows of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from nrp_lab.benchmark.tasks import MEASURES
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.comparison.judgement import Answer, combined
from nrp_lab.sweep.agreement import cell_of, judged_rows
from nrp_lab.sweep.record import INVALID
from nrp_lab.sweep.table import Row


def answer_of(grid: RunGrid, rows: Sequence[Row]) -> Answer:
    """Return what the finding of an experiment depends on; NONE for a single pair of backends.

    Backends that cannot begin the task with any partner are left out.

    Args:
        grid: the grid of runs.
        rows: the rows of those that have ended.
    """
    begun = [row for row in rows if row["state"] != INVALID]
    cells = [cell_of(row) for row in begun]
    brains = tuple(name for name in grid.brains if any(cell.brain == name for cell in cells))
    worlds = tuple(name for name in grid.worlds if any(cell.world == name for cell in cells))
    if len(brains) * len(worlds) < 2:
        return Answer.NONE
    able = replace(grid, brains=brains, worlds=worlds)
    return combined(one.answer for one in judged_rows(able, begun, MEASURES))
