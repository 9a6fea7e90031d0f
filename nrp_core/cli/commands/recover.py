"""``nrp recover``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, usage_errors
from nrp_core.cli.output import document


def recover(
    recording: Annotated[
        Path, typer.Argument(metavar="DIR", help="A recording whose run was killed, or its .mcap file.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            envvar="NRP_OUTPUT",
            help="The file to write; by default it replaces the damaged file, which is kept renamed.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Recover the intact part of a recording that is truncated or damaged."""
    from nrp_core.recording.reading.recording import Recording
    from nrp_core.recording.reading.recover import recover as recovered

    with usage_errors("DIR"):
        source = Recording(recording)
    outcome = recovered(source, output)
    if json:
        document(outcome)
    elif outcome.kept is None:
        typer.echo(f"{source.file} is complete: nothing to recover")
    else:
        typer.echo(f"{outcome.file}: {outcome.messages} messages, {outcome.until_s:g} s")
        typer.echo(f"the original file is kept as {outcome.kept}")
