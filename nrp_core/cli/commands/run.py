"""``nrp run``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import (
    BrainName,
    ExperimentName,
    Ignore,
    Json,
    Models,
    Overrides,
    Overwrite,
    Seed,
    Verbose,
    WorldName,
    ignored_codes,
    overrides_of,
)
from nrp_core.recording.layout import Images


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
            metavar="max|realtime|FACTOR",
            envvar="NRP_PACE",
            help="Speed of simulated time relative to real time.",
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(metavar="DIR", envvar="NRP_RECORD", help="Record the run into a new folder."),
    ] = None,
    images: Annotated[
        Images,
        typer.Option(metavar="exact|jpeg|hash|off", envvar="NRP_IMAGES", help="How to record camera images."),
    ] = Images.EXACT,
    snapshots: Annotated[
        str,
        typer.Option(
            metavar="TIME|off",
            envvar="NRP_SNAPSHOTS",
            help="Time between two recorded snapshots of the state.",
        ),
    ] = "10s",
    plot: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            envvar="NRP_PLOT",
            help="Draw a figure of the run into a .png, .svg or .pdf file; repeatable.",
        ),
    ] = None,
    control: Annotated[
        Path | None,
        typer.Option(
            metavar="SOCKET",
            envvar="NRP_CONTROL",
            help="Accept nrp publish and nrp functions on this Unix socket.",
        ),
    ] = None,
    allow_incomplete: Annotated[
        bool,
        typer.Option(
            "--allow-incomplete",
            envvar="NRP_ALLOW_INCOMPLETE",
            help="Succeed even if parts of the experiment were left out or functions were stopped.",
        ),
    ] = False,
    save_brain: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.nrpnet",
            envvar="NRP_SAVE_BRAIN",
            help="Save the brain as a network file, with the weights that it has learned.",
        ),
    ] = None,
    ignore: Ignore = None,
    verbose: Verbose = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Run an experiment; fail if the run is not complete or one of its criteria is not met.

    Ctrl-C ends the run between two steps: its recording is complete, and the exit code is 130.
    """
    from nrp_core.cli.output import complain
    from nrp_core.cli.session import RunRequest, Session
    from nrp_core.findings import InvalidExperimentError

    if record is None and (images is not Images.EXACT or snapshots != "10s"):
        complain("--images and --snapshots have no effect without --record", label="note")
    settings = overrides_of(overrides, brain=brain, world=world, models=models, seed=seed, pace=pace)
    request = RunRequest(
        experiment,
        settings,
        until,
        record,
        images,
        snapshots,
        tuple(plot or ()),
        overwrite,
        control,
        allow_incomplete,
        verbose,
        tuple(ignored_codes(ignore)),
        save_brain,
    )
    try:
        code = Session(request).run(as_json=json)
    except InvalidExperimentError as error:
        from nrp_core.checks.validate import refined

        raise refined(error, experiment, settings) from None
    raise typer.Exit(code)
