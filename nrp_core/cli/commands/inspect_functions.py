"""``nrp inspect`` of a file of transfer functions, in any format that is known; nothing in it is run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.failure import complain
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core.dsl.functions.function import TransferFunction


def are_functions(file: Path) -> bool:
    """Tell whether a file is of a kind that transfer functions are written in."""
    from nrp_core.experiment.making.maker import LISTERS

    return file.is_file() and file.suffix in LISTERS.names()


def inspect_functions(file: Path, *, as_json: bool) -> None:
    """Tell each transfer function with what it reads, drives and returns, and what is wrong with them.

    Raises:
        ExperimentError: the file cannot be read, or there is none in it.
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
