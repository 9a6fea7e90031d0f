"""``nrp diff --evidence``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os.path import relpath
from pathlib import Path

import typer

from nrp_core.cli.options import usage_errors
from nrp_core.cli.output import document
from nrp_core.cli.progress import display
from nrp_core.experiment import keyed_range
from nrp_core.utilities import cores, replace_file
from nrp_lab.comparison.evidence import Doing, evidence_grid, gather
from nrp_lab.comparison.metric import Margins, all_metrics


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
        folder = page.absolute().parent
        html = report_page.evidence_page(
            found, lambda cell: Path(relpath(found.folder(cell), folder)).as_posix()
        )
    replace_file(page, html)
    if as_json:
        document(report.evidence_data(found) | {"page": page})
    else:
        report.print_evidence(found, Console(highlight=False))
        typer.echo(f"written to {page}")
    return found.doing is not Doing.OPEN
