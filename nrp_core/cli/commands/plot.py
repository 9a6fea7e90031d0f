"""``nrp plot``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.failure import complain
from nrp_core.cli.options import Json, usage_errors
from nrp_core.cli.output import document


def plot(
    recording: Annotated[Path, typer.Argument(metavar="DIR", help="A folder made by nrp run --record.")],
    what: Annotated[
        str,
        typer.Argument(
            metavar="[run|raster|trajectory|devices|camera]", envvar="NRP_WHAT", help="The figure to draw."
        ),
    ] = "run",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            envvar="NRP_OUTPUT",
            help="A .png, .svg or .pdf file; by default WHAT.png in the current folder.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Draw a figure of a recorded run: all of it, or one part."""
    from nrp_core.errors import did_you_mean
    from nrp_core.recording import figures as figure
    from nrp_core.recording.reading.recording import Recording

    with usage_errors("DIR"):
        source = Recording(recording)
    with usage_errors("WHAT"):
        if what not in (known := [one.value for one in figure.What]):
            raise ValueError(f"unknown figure '{what}'{did_you_mean(what, known)}")
    target = output or Path(f"{what}.png")
    with usage_errors("--output"):
        figure.check_target(target)
    if not source.complete:
        complain(
            "the recording is truncated or damaged: only its intact part is drawn",
            label="warning",
            color="yellow",
        )
    figure.plot(source, target, figure.What(what))
    if json:
        document({"figure": target, "complete": source.complete})
    else:
        typer.echo(target)
