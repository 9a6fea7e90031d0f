"""``nrp share``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, Overwrite, RecordingPath, open_recording, require_writable
from nrp_core.cli.output import document, size_text, warn
from nrp_core.utilities import replace_file


def share(
    recording: RecordingPath,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="The file; by default DIR.html."),
    ] = None,
    max_size: Annotated[
        float, typer.Option(min=2, max=1000, metavar="MB", help="The maximum size of the file, MB.")
    ] = 15.0,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a recording and the page that shows it into one HTML file, which needs no server and no network.

    The largest topics are thinned until the file fits; the file and this command say which.
    """
    from nrp_cockpit.sharing.sharing import shared_file

    folder = open_recording(recording, "shared").folder
    file = output or folder.absolute().with_name(f"{folder.absolute().name}.html")
    require_writable(file, "--output", overwrite=overwrite)
    shared = shared_file(folder, round(max_size * 1e6))
    replace_file(file, shared.html)
    if json:
        document({"file": file, "bytes": file.stat().st_size, "losses": shared.losses})
        return
    for loss in shared.losses:
        warn(loss)
    typer.echo(f"{file} ({size_text(file.stat().st_size)})")
