"""``nrp backends`` and ``nrp doctor``: the installed backends, and missing features of this machine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import Json
from nrp_core.cli.output import NO, document

if TYPE_CHECKING:
    from nrp_core._support.diagnosis import Diagnosis
    from nrp_core.cli.survey import Surveyed


def doctor(json: Json = False) -> None:
    """List programs and features that this machine lacks, and what they are needed for.

    Fail if no brain backend or no world backend can run here.
    """
    from nrp_core._support.machine import describe_machine, diagnose
    from nrp_core.cli.survey import survey

    machine, surveyed = diagnose(), survey(refresh=True)
    healthy = all(any(b.available for b in surveyed if b.kind == kind) for kind in ("brain", "world"))
    if json:
        backends = [as_data(backend) for backend in surveyed]
        document(
            {"healthy": healthy, "machine": describe_machine(), "diagnoses": machine, "backends": backends}
        )
    else:
        for line in (*_about("this machine", list(map(_line, machine))), *_about_backends(surveyed)):
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


def _about_backends(surveyed: list[Surveyed]) -> Iterator[str]:
    for backend in surveyed:
        lines = [_line(one) for one in backend.diagnoses]
        if not backend.available and all(one.present for one in backend.diagnoses):
            lines.append(f"  {typer.style('✗', fg='red')} {backend.advice}")
        yield from _about(f"{backend.kind} {backend.provider.name}", lines)


def backends(
    refresh: Annotated[
        bool,
        typer.Option("--refresh", envvar="NRP_REFRESH", help="Check again, ignoring cached results."),
    ] = False,
    json: Json = False,
) -> None:
    """List the installed backends: their capabilities, or why they cannot be used."""
    from nrp_core.cli.survey import survey

    found = survey(refresh=refresh)
    if json:
        document({"backends": [as_data(backend) for backend in found]})
        return
    for backend in found:
        for line in _lines(backend):
            typer.echo(line)
    if not found:
        typer.echo("no backend is installed; try: pip install nrp-core")


def as_data(backend: Surveyed) -> dict[str, Any]:
    """Return all data about a backend as a dictionary."""
    return {
        "kind": backend.kind,
        "name": backend.provider.name,
        "distribution": backend.provider.distribution,
        "version": backend.provider.version,
        "target": backend.provider.target,
        "available": backend.available,
        "capabilities": backend.capabilities,
        "reason": backend.reason or None,
        "remedy": backend.remedy or None,
        "diagnoses": backend.diagnoses,
    }


def _lines(backend: Surveyed) -> Iterator[str]:
    provider = backend.provider
    mark = typer.style("✓", fg="green") if backend.available else typer.style("✗", fg="red")
    name = typer.style(provider.name, bold=True)
    yield f"{mark} {backend.kind} {name}  {provider.distribution} {provider.version}"
    if not backend.available:
        yield f"    {backend.advice}"
    for name, value in _capability_texts(backend.capabilities):
        yield f"    {name:<16} {value}"


def _capability_texts(capabilities: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the name and value of each capability as text."""
    for name, value in capabilities.items():
        if name.endswith("_ns"):
            steps = "exact" if value is None else f"{value / 1e6:g} ms"
            yield name.removesuffix("_ns").replace("_", " "), steps
        elif isinstance(value, list):
            yield name.replace("_", " "), ", ".join(map(str, value)) or "none"
        else:
            yield name.replace("_", " "), ("no", "yes")[value] if isinstance(value, bool) else str(value)
