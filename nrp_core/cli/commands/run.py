"""``nrp run``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import (
    BrainName,
    ExperimentName,
    Json,
    Models,
    Overrides,
    Seed,
    WorldName,
    overrides_of,
)
from nrp_core.recording.layout import Pictures


def run(
    experiment: ExperimentName,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    models: Models = None,
    until: Annotated[
        str | None, typer.Option(metavar="TIME", envvar="NRP_UNTIL", help="Stop at this time, e.g. 20s.")
    ] = None,
    seed: Seed = None,
    pace: Annotated[
        str | None,
        typer.Option(
            metavar="max|realtime|FACTOR", envvar="NRP_PACE", help="How fast simulated time passes."
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(metavar="DIR", envvar="NRP_RECORD", help="Record everything into a new folder."),
    ] = None,
    pictures: Annotated[
        Pictures,
        typer.Option(
            metavar="exact|jpeg|hash|off", envvar="NRP_PICTURES", help="How camera pictures are recorded."
        ),
    ] = Pictures.EXACT,
    snapshots: Annotated[
        str,
        typer.Option(
            metavar="TIME|off", envvar="NRP_SNAPSHOTS", help="How often a recording keeps the whole state."
        ),
    ] = "10s",
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", envvar="NRP_PLOT", help="Draw a figure: a .png, .svg or .pdf file."),
    ] = None,
    control: Annotated[
        Path | None,
        typer.Option(metavar="SOCKET", envvar="NRP_CONTROL", help="Let nrp publish talk to the run here."),
    ] = None,
    json: Json = False,
) -> None:
    """Run an experiment; fails if a criterion of it is not met.

    Ctrl-C ends it between two steps: what was recorded is complete, and the exit code is 130.
    """
    from nrp_core.cli.session import RunRequest, Session
    from nrp_core.findings import InvalidExperimentError

    settings = overrides_of(overrides, brain=brain, world=world, models=models, seed=seed, pace=pace)
    request = RunRequest(experiment, settings, until, record, pictures, snapshots, plot, control)
    try:
        code = Session(request).run(as_json=json)
    except InvalidExperimentError as error:
        from nrp_core.analysis.validate import refined

        raise refined(error, experiment, settings) from None
    raise typer.Exit(code)
