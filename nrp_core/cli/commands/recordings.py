"""``nrp export`` and ``nrp recover``: convert and repair recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, RecordingPath, beginning_with, open_recording, usage_errors
from nrp_core.cli.output import document

FORMATS = ("nwb", "sonata", "csv")
_FILES = (".csv", ".h5", ".nwb")
"""Suffixes of the files in an exported folder, or of one that is a file itself."""


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
    from nrp_core.recording.reading.recover import recover as recovered
    from nrp_core.recording.recording import Recording

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


def export(
    recording: RecordingPath,
    kind: Annotated[
        str,
        typer.Option(
            "--format",
            "-f",
            metavar="|".join(FORMATS),
            help="The format to write.",
            autocompletion=beginning_with(lambda: FORMATS),
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="PATH",
            envvar="NRP_OUTPUT",
            help="A new file (nwb) or folder; by default named after DIR, in the current folder.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Write a recording as NWB, SONATA or CSV."""
    if kind not in FORMATS:
        from nrp_core.errors import did_you_mean

        raise typer.BadParameter(
            f"unknown format '{kind}'{did_you_mean(kind, FORMATS)}", param_hint="--format"
        )
    from nrp_core.recording.export import Format
    from nrp_core.recording.export import export as write

    source = open_recording(recording, "exported")
    name = source.folder.resolve().name
    target = output or Path(f"{name}.nwb" if kind == Format.NWB else f"{name}-{kind}")
    if kind != Format.NWB and target.suffix in _FILES:
        raise typer.BadParameter(
            f"{kind} is written as a folder of files, and '{target.name}' is the name of a file",
            param_hint="--output",
        )
    files = write(source, Format(kind), target)
    if json:
        document({"format": kind, "files": files, "complete": source.complete})
    else:
        for file in files:
            typer.echo(file)
