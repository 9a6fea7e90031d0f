"""``nrp import``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, Models
from nrp_core.cli.output import document


def import_experiment(
    file: Annotated[
        Path, typer.Argument(metavar="EXPERIMENT.exc", help="The platform's experiment file, or its folder.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Write to this folder.")],
    models: Models = None,
    json: Json = False,
) -> None:
    """Convert an experiment of the Neurorobotics Platform to this program's own format."""
    from nrp_core.cli.options import overrides_of
    from nrp_legacy.convert.folder import FILE, write_folder
    from nrp_legacy.reader import read_exc

    if output.is_dir() and any(output.iterdir()):
        raise typer.BadParameter(f"the folder {output} is not empty", param_hint="--output")
    documents = sorted(file.glob("*.exc")) if file.is_dir() else [file]
    if not documents:
        raise typer.BadParameter(f"there is no .exc file in the folder {file}", param_hint="EXPERIMENT.exc")
    path = documents[0]
    overrides = overrides_of([], brain=None, world=None, models=models)
    report = write_folder(read_exc(path, overrides), output)
    if json:
        document({"file": output / FILE, **vars(report)})
        return
    typer.echo(str(output / FILE))
    for title, items in vars(report).items():
        for item in items:
            typer.echo(f"{title.replace('_', ' ')}: {item}", err=True)
