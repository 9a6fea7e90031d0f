"""``nrp explain``."""

from __future__ import annotations

from typing import Annotated

import typer

from nrp_core.cli.options import Json, beginning_with
from nrp_core.cli.output import document


def _codes() -> list[str]:
    from nrp_core.findings import Code

    return [one.name for one in Code]


def explain(
    code: Annotated[
        str | None,
        typer.Argument(
            metavar="CODE",
            help="A code such as NRP203; by default, list all codes.",
            autocompletion=beginning_with(_codes),
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Explain the code of a finding: its meaning, why it matters and how to fix it."""
    from nrp_core.errors import did_you_mean
    from nrp_core.findings import Code

    names = [one.name for one in Code]
    wanted = None if code is None else code.strip().upper()
    if wanted is not None and wanted not in names:
        hint = did_you_mean(wanted, names)
        more = hint if hint.instead else "; nrp explain lists all"
        raise typer.BadParameter(f"unknown code '{code}'{more}", param_hint="CODE")
    codes = [
        {
            "code": one.name,
            "weight": str(one.weight),
            "summary": one.summary,
            "why": one.why,
            "suggestion": one.suggestion,
        }
        for one in Code
        if wanted in (None, one.name)
    ]
    if json:
        document({"codes": codes} if wanted is None else codes[0])
    elif wanted is None:
        for one in codes:
            typer.echo(f"{one['code']}  {one['summary']}")
    else:
        typer.echo(
            "{code}: {summary}\n\n  weight: {weight}\n  why: {why}\n  fix: {suggestion}".format(**codes[0])
        )
