"""``nrp diff``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.failure import NO
from nrp_core.cli.options import Json, Models, Overrides, overrides_of, require_folder_of, usage_errors
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from rich.console import Console

    from nrp_core.comparison.grid import RunGrid
    from nrp_core.comparison.metrics.base import Margins, Metric
    from nrp_core.comparison.result import GridDiff, PairDiff

RESULTS_SUFFIX = ".diff"


def diff(
    experiment: Annotated[
        str,
        typer.Argument(
            metavar="EXPERIMENT", help="An experiment, as for nrp run; or the first of two recordings."
        ),
    ],
    other: Annotated[
        Path | None,
        typer.Argument(metavar="DIR2", help="The second recording: compare the two without a run."),
    ] = None,
    brains: Annotated[
        str,
        typer.Option(metavar="A,B", envvar="NRP_BRAINS", help="Brain backends; by default the experiment's."),
    ] = "",
    worlds: Annotated[
        str,
        typer.Option(metavar="X,Y", envvar="NRP_WORLDS", help="World backends; by default the experiment's."),
    ] = "",
    seeds: Annotated[
        int,
        typer.Option(
            metavar="N", envvar="NRP_SEEDS", min=1, help="Number of seeds, from the experiment's seed on."
        ),
    ] = 20,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW..HIGH",
            help="Draw a setting at random for each seed, e.g. 'events.go.at=4..8 s'; repeatable.",
        ),
    ] = None,
    margin: Annotated[
        list[str] | None,
        typer.Option(
            metavar="METRIC=VALUE",
            help="Largest difference that does not matter, in the metric's unit or as 2sd, for a METRIC or a "
            "METRIC/PART; repeatable.",
        ),
    ] = None,
    overrides: Overrides = None,
    models: Models = None,
    results: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            envvar="NRP_RESULTS",
            file_okay=False,
            help="Folder of the recorded runs; runs that it already holds are not repeated.",
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(metavar="N", envvar="NRP_JOBS", min=1, help="Number of runs in parallel.")
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", envvar="NRP_HTML", dir_okay=False, help="Also write an HTML page."),
    ] = None,
    json: Json = False,
) -> None:
    """Tell whether a result depends on the simulator and where runs diverge; fail if it does or may."""
    from nrp_core.comparison.metrics.base import Margins, all_metrics

    require_folder_of(html, "--html")
    if html is not None:
        from nrp_core.recording.figures import require_matplotlib

        with usage_errors("--html"):
            require_matplotlib()
    metrics = all_metrics()
    if other is not None:
        _two(Path(experiment), other, metrics, html, as_json=json)
    with usage_errors("--margin"):
        margins = Margins.parse(margin or (), metrics)
    settings = overrides_of(overrides, brain=None, world=None, models=models)
    grid = _grid(experiment, brains, worlds, seeds, settings, vary or [])
    found = _compared(grid, metrics, margins, results or _folder(experiment), jobs)
    _report(found, html, as_json=json)
    raise typer.Exit(0 if found.answer.is_independent else NO)


def _grid(
    experiment: str, brains: str, worlds: str, seeds: int, settings: list[str], vary: list[str]
) -> RunGrid:
    from nrp_core.comparison.grid import RunGrid
    from nrp_core.experiment.model.ranges import keyed_range

    with usage_errors("--vary"):
        varied = dict(map(keyed_range, vary))
    grid = RunGrid.of(experiment, _names(brains), _names(worlds), seeds, settings, varied)
    if len(grid.brains) * len(grid.worlds) < 2:
        raise typer.BadParameter(
            "give two names to at least one of the two options", param_hint="--brains, --worlds"
        )
    return grid


def _compared(
    grid: RunGrid, metrics: list[Metric], margins: Margins, results: Path, jobs: int | None
) -> GridDiff:
    from nrp_core._support.machine import cores
    from nrp_core.cli.progress import display
    from nrp_core.comparison.result import GridDiff
    from nrp_core.comparison.running import run_grid

    with display() as shown:
        runs = run_grid(
            grid, results, jobs or cores(), lambda done, total, last: shown.count("runs", done, total, last)
        )
        shown.begin_task("comparing the runs")
        return GridDiff.of(grid, runs, metrics, margins, results)


def _two(one: Path, other: Path, metrics: list[Metric], html: Path | None, *, as_json: bool) -> None:
    from nrp_core.comparison.result import PairDiff

    found = PairDiff.of(one, other, metrics)
    _report(found, html, as_json=as_json)
    raise typer.Exit(0 if found.is_identical else NO)


def _report(found: GridDiff | PairDiff, html: Path | None, *, as_json: bool) -> None:
    from rich.console import Console

    data, page, tell = _forms(found)
    if html is not None:
        _write(html, page(found))
    if as_json:
        document(data(found))
        return
    tell(found, Console(highlight=False))
    if html is not None:
        typer.echo(f"written to {html}")


def _forms(
    found: GridDiff | PairDiff,
) -> tuple[Callable[[Any], Any], Callable[[Any], str], Callable[[Any, Console], None]]:
    from nrp_core.comparison.report.data import grid_data, pair_data
    from nrp_core.comparison.report.page import grid_page, pair_page
    from nrp_core.comparison.report.text import tell_grid, tell_pair
    from nrp_core.comparison.result import GridDiff

    if isinstance(found, GridDiff):
        return grid_data, grid_page, tell_grid
    return pair_data, pair_page, tell_pair


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def _folder(experiment: str) -> Path:
    """Return the default folder of the results, in the current folder."""
    return Path(Path(experiment).resolve().name).with_suffix(RESULTS_SUFFIX)


def _write(path: Path, text: str) -> None:
    from nrp_core._support.writing import writing

    with writing(path):
        path.write_text(text, "utf-8")
