"""``nrp plot``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import (
    Json,
    Overwrite,
    RecordingPath,
    beginning_with,
    open_recording,
    time_s,
    usage_errors,
)
from nrp_core.cli.output import complain, document

if TYPE_CHECKING:
    from nrp_core.recording.figures.style import PlotOptions

FIGURES = ("run", "raster", "trajectory", "devices", "camera")
_DPI = 150
PANELS = ("map", "timeline", "spikes", "voltages", "devices", "commands", "observables", "camera")


def plot(
    recording: RecordingPath,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="FIGURE",
            envvar="NRP_FIGURE",
            help=f"The figure to draw: {', '.join(FIGURES)}.",
            autocompletion=beginning_with(lambda: FIGURES),
        ),
    ] = "run",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            envvar="NRP_OUTPUT",
            help="A .png, .svg or .pdf file; by default FIGURE.png in the current folder.",
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WxH", envvar="NRP_SIZE", help="Width and height (180x120mm), or a width (85mm)."
        ),
    ] = None,
    dpi: Annotated[
        int, typer.Option(min=10, max=2400, envvar="NRP_DPI", help="Dots per inch of a PNG file.")
    ] = _DPI,
    begin: Annotated[
        str, typer.Option("--from", metavar="TIME", help="Show the run from this time on, e.g. 2s.")
    ] = "0s",
    until: Annotated[
        str | None, typer.Option("--until", metavar="TIME", help="Show the run up to this time.")
    ] = None,
    panels: Annotated[
        str | None,
        typer.Option(
            metavar="A,B",
            envvar="NRP_PANELS",
            help=f"Draw only these parts of the page: {', '.join(PANELS)}.",
            autocompletion=lambda incomplete: _with_next(incomplete),
        ),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Draw a figure of a recorded run: all of it, or one part."""
    from nrp_core.errors import did_you_mean
    from nrp_core.recording import figures as figure

    source = open_recording(recording, "drawn")
    with usage_errors("FIGURE"):
        if kind not in (known := [one.value for one in figure.What]):
            raise ValueError(f"unknown figure '{kind}'{did_you_mean(kind, known)}")
    target = output or Path(f"{kind}.png")
    with usage_errors("--output"):
        figure.check_target(target, overwrite=overwrite)
    if panels is not None and kind != figure.What.RUN:
        complain(f"--panels has no effect on '{kind}', which is one part", label="note")
    if dpi != _DPI and target.suffix.lower() != ".png":
        complain("--dpi has no effect on a figure that is not a PNG file", label="note")
    options = _options(size, dpi, begin, until, panels)
    if options.crowded and kind == figure.What.RUN:
        advice = "at least 150x100mm, choose --panels, or draw one part, such as 'raster'"
        complain(f"the texts of all panels overlap on {size}: use {advice}", label="note", color="yellow")
    figure.plot(source, target, figure.What(kind), options, overwrite=overwrite)
    if json:
        document({"figure": target, "complete": source.complete})
    else:
        typer.echo(target)


def _with_next(incomplete: str) -> list[str]:
    """Return completions of a list of panels: one for each name that its last word begins."""
    *chosen, last = incomplete.split(",")
    return [",".join((*chosen, name)) for name in PANELS if name.startswith(last)]


def _options(size: str | None, dpi: int, begin: str, until: str | None, panels: str | None) -> PlotOptions:
    from nrp_core.recording.figures.style import PlotOptions, panels_of, size_inches

    given: dict[str, Any] = {"dpi": dpi}
    with usage_errors("--size"):
        given["size_inches"] = None if size is None else size_inches(size)
    given["begin_s"] = time_s(begin, "--from")
    if until is not None:
        given["end_s"] = time_s(until, "--until")
        with usage_errors("--until"):
            if given["end_s"] <= given["begin_s"]:
                raise ValueError(f"expected a time after {begin}, not {until}")
    with usage_errors("--panels"):
        if panels is not None:
            given["panels"] = panels_of(panels)
    return PlotOptions(**given)
