"""``nrp schema``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from nrp_core.cli.options import Json
from nrp_core.cli.output import document


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
