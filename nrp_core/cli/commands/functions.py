"""``nrp functions``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from nrp_core.cli.failure import NO, report
from nrp_core.cli.options import Json, SocketPath
from nrp_core.cli.output import document


def functions(
    socket: SocketPath,
    add: Annotated[
        list[Path] | None,
        typer.Option(
            "--add",
            metavar="FILE",
            exists=True,
            dir_okay=False,
            help="Add the functions of a file; each replaces the function of the same name.",
        ),
    ] = None,
    remove: Annotated[
        list[str] | None, typer.Option("--remove", metavar="NAME", help="Remove a function.")
    ] = None,
    activate: Annotated[
        list[str] | None, typer.Option("--activate", metavar="NAME", help="Resume a function.")
    ] = None,
    deactivate: Annotated[
        list[str] | None, typer.Option("--deactivate", metavar="NAME", help="Pause a function.")
    ] = None,
    json: Json = False,
) -> None:
    """List or change the transfer functions of a run that was started with --control SOCKET."""
    from nrp_core.errors import ExperimentError
    from nrp_core.experiment.running.control import tell

    try:
        found: list[dict[str, Any]] = tell(
            socket, "functions", add=[str(path.absolute()) for path in add or ()],
            remove=_given(remove), activate=_given(activate), deactivate=_given(deactivate),
        )  # fmt: skip
    except ExperimentError as error:
        report(error, as_json=json)
        raise typer.Exit(NO) from None
    if json:
        document({"functions": found})
        return
    for one in found:
        state = "active" if one["active"] else "failed" if one["failure"] else "paused"
        typer.echo(f"{one['name']}  {state}  {one['flow']}, {one['place']}")


def _given(names: Sequence[str] | None) -> list[str]:
    return list(names or ())
