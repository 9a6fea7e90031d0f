"""``nrp diff --evidence``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from io import StringIO
from os.path import relpath
from pathlib import Path
from typing import Any

import typer

from nrp_core.cli.options import usage_errors
from nrp_core.cli.output import document
from nrp_core.cli.progress import display
from nrp_core.errors import NrpError
from nrp_core.experiment import keyed_range
from nrp_core.recording import RUN_NAME
from nrp_core.registry import Registry
from nrp_core.utilities import cores, replace_file
from nrp_lab.comparison.evidence import Doing, Evidence, evidence_grid, gather
from nrp_lab.comparison.grid import ORIGINAL, GridCell
from nrp_lab.comparison.metric import Margins, all_metrics

PLAYER_MB = 5.0
"""Size of the page that plays a run."""


@dataclass(frozen=True)
class Request:
    """The options of the command, as for ``nrp diff``.

    Args:
        experiment: its name, file or folder.
        controls: controls of the wiring.
        others: other exchanges; see :func:`~nrp_lab.comparison.evidence.evidence_grid`.
        seeds: number of seeds.
        settings: overrides.
        vary: settings that are drawn with each seed.
        results: folder of the runs.
        jobs: number of processes.
        margins: the margins.
    """

    experiment: str
    controls: Sequence[str]
    others: Mapping[str, Sequence[str]]
    seeds: int
    settings: Sequence[str]
    vary: Sequence[str]
    results: Path | None
    jobs: int | None
    margins: Margins


def write_evidence(request: Request, page: Path, *, as_json: bool) -> bool:
    """Gather the evidence and write it; return whether the question is decided."""
    from rich.console import Console

    from nrp_lab.comparison import report, report_page

    with usage_errors("--vary"):
        varied = dict(map(keyed_range, request.vary))
    grid = evidence_grid(
        request.experiment, request.controls, request.others, request.seeds, request.settings, varied
    )
    metrics = all_metrics()
    request.margins.require_possible(metrics, grid.load(grid.cells[0]))
    results = request.results or page.with_suffix(".runs")
    with display() as shown:
        found = gather(
            grid, results, request.jobs or cores(),
            lambda done, total, last: shown.count("runs", done, total, last), metrics, request.margins,
        )  # fmt: skip
        shown.begin_task("drawing the page")
        players = _write_players(found, lambda done, total: shown.count("players", done, total, ""))
        folder = page.absolute().parent

        def link(cell: GridCell) -> str:
            return Path(relpath(players.get(cell, found.folder(cell)), folder)).as_posix()

        html = report_page.evidence_page(found, link, players)
    replace_file(page, html)
    if as_json:
        document(report.evidence_data(found) | {"page": page})
    else:
        report.print_evidence(found, Console(highlight=False))
        typer.echo(f"written to {page}")
    return found.doing is not Doing.OPEN


def _write_players(found: Evidence, on_progress: Callable[[int, int], None]) -> dict[GridCell, Path]:
    """Write pages that play the first run of each control, if ``nrp share`` is installed."""
    commands: Registry[Any] = Registry("nrp_core.commands", "command")
    if "share" not in commands.names():
        return {}
    share, players = commands.load("share"), {}
    firsts = [next(iter(found.runs(name))) for name in (ORIGINAL, *found.controls)]
    for done, cell in enumerate(firsts, 1):
        folder = found.folder(cell)
        page = folder.with_name(f"{folder.name}.html")
        with suppress(NrpError), redirect_stdout(StringIO()):  # of a run that failed at once, say
            if not page.exists() or page.stat().st_mtime < (folder / RUN_NAME).stat().st_mtime:
                share(folder, output=page, max_size=PLAYER_MB, overwrite=True)
            players[cell] = page
        on_progress(done, len(firsts))
    return players
