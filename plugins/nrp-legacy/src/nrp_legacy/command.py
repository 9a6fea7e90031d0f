"""``nrp import``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, Models, Overwrite, Trust, usage_errors
from nrp_core.cli.output import document
from nrp_core.paths import check_free
from nrp_core.registry import Registry

Importer = Callable[[Path, Path, Sequence[str]], Mapping[str, object]]
"""Writes an experiment to a folder, given overrides, and returns lists of notes by title."""
IMPORTERS: Registry[Importer] = Registry("nrp_core.importers", "importer of experiments")
"""Importers by the suffixes of the files that they read."""
_FILE = "experiment.yaml"
_EXECUTED = (".exc",)
"""Suffixes of experiments whose code is executed to convert them."""


def import_experiment(
    file: Annotated[
        Path, typer.Argument(metavar="EXPERIMENT", help="The experiment's file (.exc, .json), or its folder.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Write to this folder.")],
    models: Models = None,
    trust: Trust = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Convert an experiment of another platform to this program's own format.

    To convert an experiment of the Neurorobotics Platform (.exc), its brain script and its functions are
    executed with your permissions, which this command asks for, or --trust grants. Of NRP-core 4 nothing is
    executed.
    """
    from nrp_core.cli.options import overrides_of
    from nrp_core.experiment import find_file

    with usage_errors("--output"):
        check_free(output, overwrite=overwrite)
    path = find_file(str(file))
    if path.suffix not in IMPORTERS.names():
        valid = ", ".join(IMPORTERS.names())
        raise typer.BadParameter(f"{path.name} is not of another platform, whose files end in {valid}")
    if path.suffix in _EXECUTED and not trust:
        _ask(path)
    overrides = overrides_of([], brain=None, world=None, models=models)
    report = IMPORTERS.load(path.suffix)(path, output, overrides)
    if json:
        document({"file": output / _FILE, **report})
        return
    typer.echo(str(output / _FILE))
    for title, items in report.items():
        assert isinstance(items, Sequence)
        for item in items:
            typer.echo(f"{title.replace('_', ' ')}: {item}", err=True)


def _ask(path: Path) -> None:
    """Ask whether the code of an experiment may be executed.

    Raises:
        typer.BadParameter: the session is not interactive.
        typer.Abort: it may not.
    """
    question = f"{path.name}: converting it executes its brain script and its functions with your permissions"
    if not sys.stdin.isatty():
        raise typer.BadParameter(f"{question}; read them, and give --trust", param_hint="--trust")
    typer.confirm(f"{question}; execute them?", abort=True, err=True)
