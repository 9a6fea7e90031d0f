"""``nrp explain``."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, Overrides, beginning_with, experiment_names
from nrp_core.cli.output import document


def _codes() -> list[str]:
    from nrp_core.findings import Code

    return [one.name for one in Code]


def _subjects(incomplete: str) -> list[str]:
    return [*beginning_with(_codes)(incomplete), *experiment_names(incomplete)]


def _parameters(context: typer.Context, incomplete: str) -> list[str]:
    """Return the names of parameters of the subject before the word; none if it cannot be read."""
    from nrp_core.cli.inspect_experiments import parameters_of

    with suppress(Exception):
        known, _ = parameters_of(context.params["subject"])
        return beginning_with(lambda: dict.fromkeys(one.name for one in known))(incomplete)
    return []


def explain(
    subject: Annotated[
        str | None,
        typer.Argument(
            metavar="CODE|FILE",
            help="A code such as NRP201; or an experiment (its name or file), a recording, a brain script or "
            "transfer functions. By default, list all codes.",
            autocompletion=_subjects,
        ),
    ] = None,
    parameter: Annotated[
        str | None,
        typer.Argument(
            metavar="PARAMETER",
            help="A parameter of the file, by name or as for --set; by default, all of them.",
            autocompletion=_parameters,
        ),
    ] = None,
    overrides: Overrides = None,
    json: Json = False,
) -> None:
    """Explain the code of a finding, or parameters of an experiment.

    Of a code: its meaning, why it matters and how to fix it. Of a parameter: its value and who set it, its
    default, unit, range and purpose, and the line that declares it. Nothing is executed.
    """
    from nrp_core.cli.inspect_experiments import explain_parameters
    from nrp_core.experiment.reading.find import shipped
    from nrp_core.findings.removed_codes import MERGED, removed_in

    names = _codes()
    code = None if subject is None else subject.strip().upper()
    if code is None or code in names:
        if parameter is not None or overrides:
            raise typer.BadParameter("a code takes no other arguments", param_hint="PARAMETER")
        _explain_codes(code, as_json=json)
    elif (version := removed_in(code)) is not None:
        other = MERGED.get(code)
        instead = "it is not reported any more" if other is None else f"{other} is reported instead"
        text = f"{code} was removed in {version}: {instead}"
        data = {"code": code, "removed_in": version, "instead": other}
        document(data) if json else typer.echo(text)
    elif parameter is not None or Path(str(subject)).exists() or subject in shipped():
        explain_parameters(str(subject), parameter, overrides or [], as_json=json)
    else:
        _refuse(str(subject), [*names, *shipped()])


def _refuse(subject: str, known: list[str]) -> None:
    from nrp_core.errors import did_you_mean

    hint = did_you_mean(subject, known)
    hint = hint if hint.instead else did_you_mean(subject.upper(), known)
    more = hint if hint.instead else "; nrp explain lists the codes, nrp list the experiments"
    raise typer.BadParameter(f"'{subject}' is neither a code nor a file{more}", param_hint="CODE")


def _explain_codes(wanted: str | None, *, as_json: bool) -> None:
    from nrp_core.findings import Code

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
    if as_json:
        document({"codes": codes} if wanted is None else codes[0])
    elif wanted is None:
        for one in codes:
            typer.echo(f"{one['code']}  {one['summary']}")
    else:
        typer.echo(
            "{code}: {summary}\n\n  weight: {weight}\n  why: {why}\n  fix: {suggestion}".format(**codes[0])
        )
