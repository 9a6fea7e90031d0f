"""The summary of a run as text."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from pathlib import Path

import typer

from nrp_core.cli.progress import shares_text
from nrp_core.experiment.running.result import Result

_MARKS = {True: ("✓", "green"), False: ("✗", "red"), None: ("?", "yellow")}


def summary(result: Result, *, interrupted: bool, recording: Path | None, figure: Path | None) -> None:
    """Write a short summary to standard output."""
    for line in _lines(result, recording, figure):
        typer.echo(line)
    typer.echo(_verdict(result, interrupted))


def _lines(result: Result, recording: Path | None, figure: Path | None) -> Iterator[str]:
    name = typer.style(result.experiment, bold=True)
    yield f"{name}: {result.brain} and {result.world}, seed {result.seed}"
    for criterion, outcome in result.criteria.items():
        yield f"  {_mark(outcome.passed)} {criterion}: {outcome.reason}"
    yield (
        f"  {result.sim_time_s:g} s in {result.wall_time_s:.1f} s, "
        f"{result.real_time_factor:.1f} x real time ({shares_text(result.time_share)})"
    )
    for robot, pose in result.final_pose.items():
        heading = f"{degrees(pose['yaw']):.0f}°"
        yield f"  {robot} ends at x {pose['x']:.2f} m, y {pose['y']:.2f} m, heading {heading}"
    if result.spikes:
        yield "  spikes: " + ", ".join(f"{name} {count}" for name, count in result.spikes.items())
    happened = [f"{name} at {t_s:g} s" for name, t_s in result.events.items() if t_s is not None]
    if happened:
        yield "  events: " + ", ".join(happened)
    if recording is not None:
        yield f"  recorded in {recording}"
    if figure is not None:
        yield f"  figure: {figure}"


def _verdict(result: Result, interrupted: bool) -> str:
    if interrupted:
        return typer.style(f"interrupted at {result.sim_time_s:g} s", fg="yellow", bold=True)
    if result.error is not None:
        return typer.style(f"failed at {result.sim_time_s:g} s", fg="red", bold=True)
    if not result.criteria:
        return typer.style("done", fg="green", bold=True)
    words = {
        True: "passed",
        False: "failed: a criterion is not met",
        None: "not decided: the run ended early",
    }
    return typer.style(words[result.passed], fg=_MARKS[result.passed][1], bold=True)


def _mark(passed: bool | None) -> str:
    mark, color = _MARKS[passed]
    return typer.style(mark, fg=color)
