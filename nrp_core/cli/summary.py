"""The summary of a run as text."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from math import degrees
from pathlib import Path

import typer

from nrp_core.cli.output import complain, size_text
from nrp_core.cli.progress import shares_text
from nrp_core.experiment.running.result import FAILED, FINISHED, Judgement, Result
from nrp_core.findings import Finding, Level, Weight
from nrp_core.findings.problems import lines_of, ordered
from nrp_core.quantities import length_text

_MARKS = {True: ("✓", "green"), False: ("✗", "red"), None: ("?", "yellow")}
_WEIGHT_COLORS = {Weight.INCOMPLETE: "red", Weight.ALTERED: "yellow", Weight.REMARK: None}


def summary(
    result: Result, *, recording: Path | None, figures: Sequence[Path], fixed: Collection[str], details: bool
) -> None:
    """Write a short summary to standard output: the problems first, the judgement last.

    Args:
        result: the result of the run.
        recording: the folder of its recording, if any.
        figures: the files of its figure.
        fixed: the robots with a fixed base, which end where they began.
        details: whether to write each problem, not only their number.
    """
    name = typer.style(result.experiment, bold=True)
    typer.echo(f"{name}: {result.brain} and {result.world}, seed {result.seed}")
    print_problems(result.judgement, details=details)
    for line in _lines(result, recording, figures, fixed):
        typer.echo(line)
    typer.echo(styled_headline(result.judgement))


def print_problems(judgement: Judgement, *, details: bool) -> None:
    """Write the problems of a run, coloured by weight."""
    _print_groups(judgement.problems, details=details, err=False)


def print_findings(findings: Sequence[Finding], *, details: bool) -> None:
    """Write findings to standard error: each error with its reason and its fix, then a line for each code.

    Args:
        findings: the findings.
        details: whether to write each finding of a code, not only their number, and those of a remark.
    """
    explained = set()
    for finding in findings:
        if finding.level is Level.ERROR:
            complain(str(finding))
            if finding.code not in explained:
                explained.add(finding.code)
                typer.echo(f"    why: {finding.code.why}\n    fix: {finding.code.suggestion}", err=True)
    others = ordered(finding for finding in findings if finding.level is not Level.ERROR)
    _print_groups(others, details=details, err=True)


def _print_groups(problems: Sequence[Finding], *, details: bool, err: bool) -> None:
    lines = list(lines_of(problems, details=details, places=err))
    for weight, line in lines:
        typer.secho(f"  {line}", fg=_WEIGHT_COLORS[weight], err=err)
    if problems and not details:
        has_more = lines != list(lines_of(problems, details=True))
        more = "-v shows each problem, " if has_more else ""
        typer.secho(f"  ({more}nrp explain CODE explains it)", dim=True, err=err)


def styled_headline(judgement: Judgement) -> str:
    """Return the judgement in one coloured line."""
    is_over = judgement.state in (FINISHED, FAILED)
    bad = judgement.passed is False or not judgement.complete
    color = (
        "yellow" if not is_over else "red" if bad else _MARKS[judgement.passed or not judgement.criteria][1]
    )
    return typer.style(judgement.headline, fg=color, bold=True)


def _lines(
    result: Result, recording: Path | None, figures: Sequence[Path], fixed: Collection[str]
) -> Iterator[str]:
    for criterion, outcome in result.criteria.items():
        yield f"  {_mark(outcome.passed)} {criterion}: {outcome.reason}"
    yield (
        f"  {result.sim_time_s:g} s in {result.wall_time_s:.1f} s, "
        f"{result.real_time_factor:.1f} x real time ({shares_text(result.time_share)})"
    )
    for robot, pose in result.final_pose.items():
        if robot in fixed:
            continue
        heading = f"{degrees(pose['yaw']):.0f}°"
        x, y = length_text(pose["x"]), length_text(pose["y"])
        yield f"  {robot} ends at x {x}, y {y}, heading {heading}"
    if result.spikes:
        yield "  spikes: " + ", ".join(f"{name} {count}" for name, count in result.spikes.items())
    happened = [f"{name} at {t_s:g} s" for name, t_s in result.events.items() if t_s is not None]
    if happened:
        yield "  events: " + ", ".join(happened)
    if recording is not None:
        size = sum(file.stat().st_size for file in recording.rglob("*") if file.is_file())
        yield f"  recorded in {recording} ({size_text(size)})"
    for figure in figures:
        yield f"  figure: {figure}"


def _mark(passed: bool | None) -> str:
    mark, color = _MARKS[passed]
    return typer.style(mark, fg=color)
