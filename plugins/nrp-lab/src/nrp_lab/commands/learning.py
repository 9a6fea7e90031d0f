"""``nrp benchmark learning``."""

from __future__ import annotations

from pathlib import Path

import typer

from nrp_core.cli.output import document
from nrp_core.cli.progress import display


def benchmark_learning(
    tasks: list[str], learner: str, brain: str, world: str, seeds: int, workers: int | None, out: Path, *,
    as_json: bool,
) -> None:  # fmt: skip
    """Train a learner in tasks with several seeds, and report tests, baselines and learning curves."""
    from nrp_lab.learning.ladder import Ladder
    from nrp_lab.learning.learner import find_learner
    from nrp_lab.learning.report import FIGURE, draw, report, rows_of, write_csv

    ladder = Ladder(tasks, find_learner(learner), brain or "event", world or "mujoco", seeds, out)
    typer.echo(f"{len(ladder.tasks)} tasks, {len(ladder.pending)} trials to do; results in {out}", err=True)
    if ladder.news:
        typer.echo(ladder.news, err=True)
    with display() as shown:
        ladder.run(workers, lambda done, total: shown.count("trials", done, total, ""))
    found = ladder.standings()
    table, figure = write_csv(found, out), draw(found, out / FIGURE)
    if as_json:
        document({"folder": out, "rows": rows_of(found)})
        return
    from rich.console import Console

    report(found, Console(highlight=False, width=120))
    typer.echo(f"table: {table}; learning curves: {figure}; all episodes: {out}/TASK-SEED.json")
