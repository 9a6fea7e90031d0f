"""``nrp inspect`` of a file of transfer functions in any known format; none of its code is run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.failure import complain
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core.dsl.functions.function import TransferFunction


def are_functions(file: Path) -> bool:
    """Return whether a file has the suffix of a format of transfer functions."""
    from nrp_core.experiment.making.maker import LISTERS

    return file.is_file() and file.suffix in LISTERS.names()


def inspect_functions(file: Path, *, as_json: bool) -> None:
    """Print each transfer function with its inputs, outputs and return value, and the findings.

    Raises:
        ExperimentError: the file cannot be read or declares no transfer function.
    """
    from nrp_core.analysis.declarations import Declarations
    from nrp_core.errors import TransferFunctionError
    from nrp_core.experiment.making.maker import LISTERS

    found = Declarations(LISTERS.load(file.suffix)(file))
    functions = [one.function for one in found.functions]
    if not (functions or found.findings):
        raise TransferFunctionError("declares no transfer function", path=file)
    if as_json:
        findings = [finding.to_dict() for finding in found.findings]
        document({"file": file, "functions": list(map(_as_data, functions)), "findings": findings})
        return
    for function in functions:
        typer.echo(str(function))
    for finding in found.findings:
        complain(str(finding), label="warning", color="yellow")


def _as_data(function: TransferFunction) -> dict[str, Any]:
    return {
        "name": function.name,
        "flow": function.flow.value,
        "line": function.place.line,
        "parameters": {name: str(function.mappings.get(name, "")) for name in function.parameters},
        "returns_to": None if function.topic is None else str(function.topic),
    }
