"""``nrp list`` and ``nrp schema``: the installed experiments and the format of their files."""

from __future__ import annotations

import textwrap
from enum import StrEnum
from typing import Annotated, Any

import typer

from nrp_core.cli.options import Json
from nrp_core.cli.output import document

_WIDTH = 110
"""Columns of the terminal for a description."""


class SchemaSubject(StrEnum):
    """The file formats with a schema."""

    EXPERIMENT = "experiment"


def schema(
    subject: Annotated[SchemaSubject, typer.Argument(metavar="SUBJECT", help="The file format to describe.")],
    json: Json = False,  # noqa: ARG001  the output is always JSON
) -> None:
    """Print the JSON Schema of a file format, for editors."""
    from nrp_core.experiment.reading.reader import experiment_schema

    schemas = {SchemaSubject.EXPERIMENT: experiment_schema}
    document(schemas[subject]())


def list(json: Json = False) -> None:  # noqa: A001  the name of the command
    """List the experiments that are installed; `nrp inspect NAME` shows one."""
    from nrp_core.experiment.reading.find import shipped

    found = [_about(name) for name in shipped()]
    if json:
        document({"experiments": found})
        return
    for one in found:
        typer.secho(one["name"], bold=True)
        for line in textwrap.wrap(one["error"] or one["description"], _WIDTH - 4):
            typer.echo(f"    {line}")


def _about(name: str) -> dict[str, Any]:
    from nrp_core.errors import NrpError
    from nrp_core.experiment.reading.find import find_file, load_experiment

    about: dict[str, Any] = {"name": name, "file": find_file(name), "description": "", "error": None}
    try:
        about["description"] = load_experiment(name).description
    except NrpError as error:  # a broken experiment must not hide the others
        about["error"] = f"cannot be read: {error}"
    return about
