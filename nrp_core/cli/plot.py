"""``nrp plot``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, usage_errors
from nrp_core.cli.output import document


def plot(
    recording: Annotated[Path, typer.Argument(metavar="DIR", help="A folder made by nrp run --record.")],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", envvar="NRP_OUTPUT", help="A .png, .svg or .pdf file."
        ),
    ] = Path("run.png"),
    json: Json = False,
) -> None:
    """Draw the figure of a recorded run."""
    from nrp_core.recording import plot as figure
    from nrp_core.recording.read import Recording

    with usage_errors("DIR"):
        source = Recording(recording)
    with usage_errors("--output"):
        figure.check_target(output)
    figure.plot(source, output)
    if json:
        document({"figure": output, "complete": source.complete})
    else:
        typer.echo(output)
