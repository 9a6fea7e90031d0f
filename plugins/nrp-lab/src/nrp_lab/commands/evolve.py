"""``nrp evolve``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.options import (
    FileOrShow,
    Json,
    On,
    Overwrite,
    PlotFile,
    ResultsFolder,
    ShownFolder,
    Workers,
    folder_to_show,
    require_writable,
    results_folder,
)
from nrp_core.cli.output import document, warn

if TYPE_CHECKING:
    from nrp_lab.evolve.history import History

_MAX_LINES = 12


def evolve(
    context: typer.Context,
    target: FileOrShow,
    folder: ShownFolder = None,
    on: On = "local",
    workers: Workers = None,
    out: ResultsFolder = None,
    plot: PlotFile = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Search for the best settings of an experiment. Stop at any time; repeat the command to resume."""
    shown = folder_to_show(context, target, folder, ("plot", "overwrite"))
    require_writable(plot, "--plot", overwrite=overwrite)
    if shown is not None:
        from nrp_lab.evolve.history import History

        _show(History.read(shown), shown, plot, as_json=json)
        return
    found = results_folder(out, Path(target), "evolve")
    history, ended = _search(Path(target), found, on, workers)
    if ended:
        _print_line(f"ended after generation {len(history) - 1}: {ended}")
    _show(history, found, plot, as_json=json)


def _search(file: Path, folder: Path, on: str, workers: int | None) -> tuple[History, str]:
    from nrp_core.cli.progress import display
    from nrp_lab.evolve.evolution import Evolution
    from nrp_lab.evolve.model import read_evolve
    from nrp_lab.sweep.executor import executor

    described, source = read_evolve(file)
    made = Evolution(described, source, folder)
    method = f"{described.optimiser} over {len(made.keys)} settings"
    size = f"{described.generations} generations of {described.population} candidates"
    seeds = f", {described.seeds} runs each" if described.seeds > 1 else ""
    _print_line(f"{made.name}: {method}; {size}{seeds}; results in {folder}")
    if made.news:
        _print_line(made.news)
    made.plan.report_warnings(warn)
    with executor(on, folder, workers) as where, display() as shown:
        last = ""

        def on_generation(history: History) -> None:
            nonlocal last
            last = _value_text(history, history.best[0])

        history = made.run(
            where,
            lambda progress: shown.count("runs", progress.done, progress.total, _status(str(progress), last)),
            on_generation,
        )
    return history, made.ended


def _status(progress: str, best: str) -> str:
    return ", ".join(part for part in (f"best {best}" if best else "", progress) if part)


def _show(history: History, folder: Path, plot: Path | None, *, as_json: bool) -> None:
    if plot is not None:
        from nrp_lab.evolve.history import draw

        draw(history, plot)
    files = sorted(folder.glob("best*.yaml"))
    if as_json:
        document(_data(history, files, folder, plot))
        return
    last = range(max(1, len(history) - _MAX_LINES), len(history))
    for generation in (0, *last):
        typer.echo(f"generation {generation}: {_spread_text(history, generation)}")
    typer.echo(f"all generations: {folder / 'generations.csv'}; all runs: {folder / 'results.csv'}")
    for candidate in history.best:
        given = " ".join(f"{key}={value}" for key, value in history.settings(candidate).items())
        typer.echo(f"best: {_value_text(history, candidate)} with {given}")
    for file in files:
        typer.echo(f"run it with: nrp run {file}")
    if plot is not None:
        typer.echo(f"figure: {plot}")


def _spread_text(history: History, generation: int) -> str:
    course = {name: numbers[generation] for name, numbers in history.course.items()}
    parts = zip(course["best"], course["mean"], course["sd"], strict=True)
    text = "; ".join(f"best {best:.4g}, mean {mean:.4g} ± {sd:.2g}" for best, mean, sd in parts)
    failed = int(course["failed"].max())
    return text + (f" ({failed} failed)" if failed else "")


def _value_text(history: History, candidate: int) -> str:
    return ", ".join(f"{value:.5g}" for value in history.values[candidate])


def _data(history: History, files: list[Path], folder: Path, plot: Path | None) -> dict[str, Any]:
    return {
        "experiment": history.name,
        "folder": folder,
        "generations": len(history),
        "population": history.population,
        "values": history.generations,
        "best": [
            {"candidate": one, "values": history.values[one], "settings": history.settings(one)}
            for one in history.best
        ],
        "files": files,
        "figure": plot,
    }


def _print_line(line: str) -> None:
    typer.echo(line, err=True)
