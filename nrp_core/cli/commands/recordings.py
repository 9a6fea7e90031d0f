"""``nrp export`` and ``nrp recover``: convert and repair recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import (
    Json,
    Overwrite,
    RecordingPath,
    beginning_with,
    open_recording,
    require_writable,
    usage_errors,
)
from nrp_core.cli.output import document
from nrp_core.paths import check_free
from nrp_core.registry import OPTIONAL, Registry

_FORMATS: Registry[object] = Registry("nrp_core.exporters", "export format")
_FILES = (".csv", ".h5", ".nwb")
"""Suffixes of the files in an exported folder, or of one that is a file itself."""


def _formats() -> str:
    """Return the installed formats, and those of our distributions that are not installed."""
    names = _FORMATS.names()
    missing = [
        f"{', '.join(sorted(more))} with pip install {distribution}"
        for distribution, groups in OPTIONAL.items()
        if (more := set(groups.get(_FORMATS.group, ())) - set(names))
    ]
    return "; ".join([", ".join(names), *missing])


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
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Recover all that is intact in a recording that is truncated or damaged."""
    from nrp_core.recording.reading.recover import recover as recovered
    from nrp_core.recording.recording import Recording

    with usage_errors("DIR"):
        source = Recording(recording)
    if output is not None:
        require_writable(output, "--output", overwrite=overwrite)
    outcome = recovered(source, output)
    if json:
        document(outcome)
    elif outcome.kept is None:
        typer.echo(f"{source.file} is complete: nothing to recover")
    else:
        lost = "" if not outcome.lost else f"; {outcome.lost} messages are lost with damaged chunks"
        typer.echo(f"{outcome.file}: {outcome.messages} messages, {outcome.until_s:g} s{lost}")
        typer.echo(f"the original file is kept as {outcome.kept}")


def export(
    recording: RecordingPath,
    kind: Annotated[
        str,
        typer.Option(
            "--format",
            "-f",
            metavar="FORMAT",
            help=f"The format to write: {_formats()}.",
            autocompletion=beginning_with(_FORMATS.names),
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="PATH",
            envvar="NRP_OUTPUT",
            help="A new file or folder, as the format needs; by default named after DIR, "
            "in the current folder.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a recording in a format of other programs."""
    from nrp_core.errors import UnknownBackendError
    from nrp_core.recording.export import export as write
    from nrp_core.recording.export import find_exporter

    try:
        suffix = find_exporter(kind).suffix
    except UnknownBackendError as error:
        raise typer.BadParameter(str(error), param_hint="--format") from error
    source = open_recording(recording, "exported")
    name = source.folder.resolve().name
    target = output or Path(f"{name}{suffix}" if suffix else f"{name}-{kind}")
    if not suffix and target.suffix in _FILES:
        raise typer.BadParameter(
            f"{kind} is written as a folder of files, and '{target.name}' is the name of a file",
            param_hint="--output",
        )
    with usage_errors("--output"):
        check_free(target, overwrite=overwrite)
    files = write(source, kind, target, overwrite=overwrite)
    if json:
        document({"format": kind, "files": files, "complete": source.complete})
    else:
        for file in files:
            typer.echo(file)
