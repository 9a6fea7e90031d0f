"""``nrp schema``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from nrp_core.cli.options import Json
from nrp_core.cli.output import document


class SchemaSubject(StrEnum):
    """What there is a schema of."""

    EXPERIMENT = "experiment"


def schema(
    subject: Annotated[SchemaSubject, typer.Argument(metavar="SUBJECT", help="What to describe.")],
    json: Json = False,  # noqa: ARG001  it is a JSON document anyway
) -> None:
    """Print the JSON Schema of a file format, for editors."""
    from nrp_core.experiment.reading.schema import experiment_schema

    schemas = {SchemaSubject.EXPERIMENT: experiment_schema}
    document(schemas[subject]())
