"""``nrp doctor``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import typer

from nrp_core.cli.failure import NO
from nrp_core.cli.options import Json
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core._support.diagnosis import Diagnosis
    from nrp_core.cli.survey import Surveyed


def doctor(json: Json = False) -> None:
    """List the things that this machine lacks, and what does not work without them.

    Fail if no brain backend or no world backend can run here.
    """
    from nrp_core._support.machine import describe, diagnose
    from nrp_core.cli.survey import survey

    machine, looked_at = diagnose(), survey(refresh=True)
    healthy = all(any(b.available for b in looked_at if b.kind == kind) for kind in ("brain", "world"))
    if json:
        from nrp_core.cli.commands.backends import as_data

        backends = [as_data(backend) for backend in looked_at]
        document({"healthy": healthy, "machine": describe(), "diagnoses": machine, "backends": backends})
    else:
        for line in (*_about("this machine", list(map(_line, machine))), *_about_backends(looked_at)):
            typer.echo(line)
        typer.echo(
            "\neverything required is installed"
            if healthy
            else "\na brain and a world backend are required; at least one of them cannot run here"
        )
    if not healthy:
        raise typer.Exit(NO)


def _about(title: str, lines: list[str]) -> Iterator[str]:
    if lines:
        yield typer.style(title, bold=True)
        yield from lines


def _line(one: Diagnosis) -> str:
    mark = typer.style("✓", fg="green") if one.present else typer.style("✗", fg="yellow")
    remedy = f"; try: {one.remedy}" if one.remedy and not one.present else ""
    return f"  {mark} {one.subject}: {one.meaning}{remedy}"


def _about_backends(looked_at: list[Surveyed]) -> Iterator[str]:
    for backend in looked_at:
        lines = [_line(one) for one in backend.diagnoses]
        if not backend.available and all(one.present for one in backend.diagnoses):
            lines.append(f"  {typer.style('✗', fg='red')} {backend.advice}")
        yield from _about(f"{backend.kind} {backend.provider.name}", lines)
