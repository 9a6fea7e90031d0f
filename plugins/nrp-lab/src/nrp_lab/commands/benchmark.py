"""``nrp benchmark``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import Json, On, Workers, beginning_with
from nrp_core.cli.output import NO, complain, document, warn

if TYPE_CHECKING:
    from nrp_core.registry import Registry
    from nrp_lab.benchmark.ladder import Ladder

_WIDTH = 120
LEARNING = "learning"
"""The first argument that selects the tasks for learners."""


def _task_names() -> list[str]:
    from nrp_lab.benchmark.tasks import TASKS

    return [*TASKS, LEARNING]


def benchmark(
    tasks: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="TASK",
            help="phototaxis, avoidance, tracking, walking, reaching; by default all. 'learning' alone or "
            "before maze, ball, pole, wall, reach, obstacles: tasks for learners.",
            autocompletion=beginning_with(_task_names),
        ),
    ] = None,
    brains: Annotated[
        str, typer.Option(metavar="A,B", envvar="NRP_BRAINS", help="Brain backends; by default all.")
    ] = "",
    worlds: Annotated[
        str, typer.Option(metavar="X,Y", envvar="NRP_WORLDS", help="World backends; by default all.")
    ] = "",
    seeds: Annotated[
        int, typer.Option(metavar="N", envvar="NRP_SEEDS", min=1, help="Number of seeds of each pair.")
    ] = 10,
    on: On = "local",
    workers: Workers = None,
    out: Annotated[
        Path,
        typer.Option(
            metavar="DIR", envvar="NRP_OUT", file_okay=False,
            help="Folder of the results; existing runs are reused.",
        ),
    ] = Path("benchmark"),
    learner: Annotated[
        str,
        typer.Option(
            metavar="NAME", envvar="NRP_LEARNER", help="With 'learning': an installed learner, or its file."
        ),
    ] = "rstdp",
    json: Json = False,
) -> None:  # fmt: skip
    """Run a ladder of closed-loop tasks on all pairs of backends, and compare their scores.

    With 'learning', train a learner on small tasks and compare it with baselines. Stop at any time; repeat
    the command to resume. The exit code is 1 if a run failed.
    """
    if tasks and tasks[0] == LEARNING:
        from nrp_lab.commands.learning import benchmark_learning

        benchmark_learning(tasks[1:], learner, brains, worlds, seeds, workers, out, as_json=json)
        return
    from nrp_core import brains as all_brains
    from nrp_core import worlds as all_worlds
    from nrp_lab.benchmark.ladder import Ladder, report, report_data, write_csv
    from nrp_lab.benchmark.tasks import tasks_of

    chosen = tasks_of(tasks or ())
    ladder = Ladder(
        chosen, named_or_all(brains, all_brains()), named_or_all(worlds, all_worlds()), seeds, out
    )
    left = "" if ladder.pending == ladder.runs else f", {ladder.pending} to do"
    typer.echo(f"{len(chosen)} tasks, {ladder.runs} runs{left}; results in {out}", err=True)
    ladder.report_warnings(warn)
    _make(ladder, on, workers)
    found = ladder.standings()
    table = write_csv(found, out)
    if json:
        document(report_data(found, out))
    else:
        from rich.console import Console

        report(found, Console(highlight=False, width=_WIDTH))
        typer.echo(f"table: {table}; all runs: {out}/TASK/results.csv")
    raise typer.Exit(NO if any(one.failed for one in found if one.score is not None) else 0)


def named_or_all(text: str, registry: Registry[Any]) -> list[str]:
    """Return the backends that were named, by default all that load; others are reported."""
    from nrp_core.errors import BackendError

    if given := [name.strip() for name in text.split(",") if name.strip()]:
        for name in given:
            registry.load(name)
        return given
    found = []
    for name in registry.names():
        try:
            registry.load(name)
            found.append(name)
        except BackendError as error:
            complain(f"left out: {error}", label="note")
    return found


def _make(ladder: Ladder, on: str, workers: int | None) -> None:
    from nrp_core.cli.progress import display
    from nrp_lab.sweep.executor import executor

    with executor(on, ladder.folder, workers) as where, display() as shown:
        ladder.run(
            where,
            lambda task, progress: shown.count(f"{task} runs", progress.done, progress.total, str(progress)),
        )
