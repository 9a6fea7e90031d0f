"""``nrp sweep``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
from nrp_core.cli.output import NO, complain, document, warn

if TYPE_CHECKING:
    from nrp_lab.sweep.executor import Executor
    from nrp_lab.sweep.plan import Plan
    from nrp_lab.sweep.running import SweepRun

_JOBS = 16


def sweep(
    context: typer.Context,
    target: FileOrShow,
    folder: ShownFolder = None,
    on: On = "local",
    workers: Workers = None,
    out: ResultsFolder = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUE|N..M", help="Make only the runs with this value or number; repeatable."
        ),
    ] = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", envvar="NRP_RETRY_FAILED", help="Repeat the runs that failed.")
    ] = False,
    record: Annotated[
        bool, typer.Option("--record", help="Keep a recording of every run, images as hashes.")
    ] = False,
    plan: Annotated[bool, typer.Option("--plan", help="Check the sweep and print its plan.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Allow any number of runs.")] = False,
    emit: Annotated[
        str | None,
        typer.Option(
            metavar="slurm|snakemake", help="Write job files for a cluster instead of running here."
        ),
    ] = None,
    measure: Annotated[
        str | None, typer.Option(metavar="METRIC.PART", help="The measure of figures; by default the first.")
    ] = None,
    plot: PlotFile = None,
    kind: Annotated[
        str | None,
        typer.Option(
            metavar="curve|heat|parallel",
            help="The kind of figure; by default chosen by the varied settings.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Run an experiment many times with varying settings. Stop at any time; repeat the command to resume.

    Ctrl-C keeps all finished runs. The exit code is 1 if a run failed.
    """
    require_writable(plot, "--plot", overwrite=overwrite)
    if plot is None and (measure is not None or kind is not None):
        complain("--measure and --kind have no effect without --plot", label="note")
    if shown := folder_to_show(context, target, folder, ("plot", "measure", "kind", "overwrite")):
        _show(shown, measure, plot, kind, as_json=json)
        return
    if emit is not None and plan:
        raise typer.BadParameter("it has no effect with --emit, which makes no run", param_hint="--plan")
    if emit is not None and on != "local":
        raise typer.BadParameter(
            f"it has no effect with --emit {emit}, which makes no run", param_hint="--on"
        )
    made = _opened(Path(target), out, only or [], retry_failed=retry_failed, record=record, confirmed=yes)
    if plot is not None:
        from nrp_lab.sweep.figures import require_figure

        require_figure(made.plan, measure, kind)
    if emit is not None:
        _emit(made, emit, workers)
        return
    failed = _make(made, on, workers, is_plan=plan)
    if on == "local" and not plan:
        made.discount_changed()
        failed += made.outdated.total()
        if made.news:
            _print_line(made.news)
    _show(made.folder, measure, plot, kind, as_json=json, may_be_empty=plan)
    raise typer.Exit(NO if failed else 0)


def _opened(
    file: Path, out: Path | None, only: list[str], *, retry_failed: bool, record: bool, confirmed: bool
) -> SweepRun:
    from nrp_lab.sweep.model import read_sweep
    from nrp_lab.sweep.plan import Plan
    from nrp_lab.sweep.running import Choice, SweepRun

    described, source = read_sweep(file)
    plan = Plan.of(described, source, confirmed=confirmed)
    made = SweepRun(plan, results_folder(out, file, "sweep"), Choice(tuple(only), retry_failed, record))
    _print_line(_headline(plan, made))
    if made.news:
        _print_line(made.news)
    if made.pending:
        plan.report_warnings(warn)
    return made


def _headline(plan: Plan, made: SweepRun) -> str:
    from nrp_lab.sweep.model import Choices, Span

    def size(axis: object) -> str:
        return str(len(axis) or "any") if isinstance(axis, (Choices, Span)) else "drawn"

    varied = " x ".join(f"{key} ({size(axis)})" for key, axis in plan.sweep.vary.items())
    total, pending = len(plan), len(made.pending)
    left = "" if pending == total else f", {pending} to do"
    design = f"{plan.sweep.design} of {varied or 'nothing'}"
    return f"{plan.name}: {total} runs{left}; {design}; results in {made.folder}"


def _make(made: SweepRun, on: str, workers: int | None, *, is_plan: bool) -> int:
    """Make the runs and return the number of those that failed.

    If no run has ended yet, the first one is made alone, to estimate the duration of all.
    """
    from nrp_core.cli.progress import display
    from nrp_lab.sweep.executor import executor
    from nrp_lab.sweep.running import Progress

    failed = 0
    with executor(on, made.folder, workers) as where, display() as shown:

        def show(progress: Progress) -> None:
            nonlocal failed
            failed = progress.failed
            shown.count("runs", progress.done, progress.total, str(progress))

        if made.pending and made.expected_s(where) is None:
            shown.begin_task("making the first run, to measure how long one takes")
            made.run(where, show, made.pending[:1])
        if made.pending:
            _print_line(_expectation(made, where))
        if not is_plan:
            made.run(where, show)
    return failed


def _expectation(made: SweepRun, where: Executor) -> str:
    from nrp_lab.sweep.running import duration_text

    pending, expected_s = len(made.pending), made.expected_s(where)
    at_once = min(where.size, pending)
    degree = "about" if len(made.records) > 1 else "at most about"  # the first run may compile code
    about = "unknown" if expected_s is None else f"{degree} {duration_text(expected_s)}"
    return f"expected time: {about} for {pending} runs, {at_once} at once"


def _emit(made: SweepRun, kind: str, jobs: int | None) -> None:
    from nrp_lab.sweep.slurm import emit

    file, command = emit(kind, made.folder, made.pending, jobs or _JOBS)
    typer.echo(f"{len(made.pending)} runs written to {file}")
    typer.echo(f"run them with: {command}")
    typer.echo("then repeat the same nrp sweep without --emit: it collects the results")


def _show(
    folder: Path, measure: str | None, plot: Path | None, kind: str | None, *, as_json: bool,
    may_be_empty: bool = False,
) -> None:  # fmt: skip
    from nrp_lab.sweep.report import report, report_data
    from nrp_lab.sweep.table import read_table

    table = read_table(folder)
    if may_be_empty and not table.rows:
        return
    if plot is not None:
        from nrp_lab.sweep.figures import draw

        draw(table, plot, measure, kind, overwrite=True)  # the command has checked it
    if as_json:
        document(report_data(table, folder, plot))
        return
    from rich.console import Console

    report(table, Console(highlight=False))
    typer.echo(f"all runs: {folder / 'results.csv'}")
    if plot is not None:
        typer.echo(f"figure: {plot}")


def _print_line(line: str) -> None:
    typer.echo(line, err=True)
