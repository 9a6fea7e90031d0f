"""``nrp inspect`` of a file of transfer functions in any known format; none of its code is run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.failure import complain
from nrp_core.cli.options import refuse_given
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core.dsl.functions import TransferFunction
    from nrp_core.experiment.making.maker import ParameterValue
    from nrp_core.experiment.model.experiment import Experiment
    from nrp_core.findings import Finding


def are_functions(file: Path) -> bool:
    """Return whether a file has the suffix of a format of transfer functions."""
    from nrp_core.experiment.making.maker import LISTERS

    return file.is_file() and file.suffix in LISTERS.names()


def inspect_functions(context: typer.Context, file: Path, overrides: Sequence[str], *, as_json: bool) -> None:
    """Print each transfer function with its inputs, outputs and return value, and the findings.

    Raises:
        ExperimentError: the file cannot be read or declares no transfer function.
        typer.BadParameter: settings are given for a file that describes no experiment.
    """
    from nrp_core.errors import TransferFunctionError
    from nrp_core.experiment.reading.reader import described_by

    experiment = described_by(file, overrides)
    if experiment is None:
        why = "it has no effect on a file of functions alone; inspect the experiment that uses it"
        refuse_given(context, why, ("overrides", "models"))
    functions, found = _contents(file, experiment)
    parameters, mistakes = declared_parameters(file)
    found += mistakes
    if not (functions or found or parameters):
        raise TransferFunctionError("declares no transfer function and no parameter", path=file)
    if as_json:
        findings = [finding.to_dict() for finding in found]
        document({
            "file": file,
            "functions": list(map(_as_data, functions)),
            "parameters": {one.parameter.name: one.as_data() for one in parameters},
            "findings": findings,
        })  # fmt: skip
        return
    for function in functions:
        typer.echo(str(function))
    for one in parameters:
        typer.echo(f"parameter {one}")
    for finding in found:
        complain(str(finding), label="warning", color="yellow")


def declared_parameters(file: Path) -> tuple[list[ParameterValue], list[Finding]]:
    """Return the parameters that a script declares, with their defaults, and declarations that are wrong."""
    from nrp_core.experiment.making.maker import ParameterValue
    from nrp_core.findings import Code, Finding
    from nrp_core.parameters import BRAIN, FUNCTIONS, Declared, read_parameters

    declared = Declared()
    for kind in (FUNCTIONS, BRAIN):
        read_parameters(file, kind, into=declared)
    # a call may be read as one of both kinds
    mistakes = dict.fromkeys(Finding.of(one, Code.NRP289) for one in declared.mistakes)
    return [ParameterValue(one, one.default) for one in declared.parameters.values()], list(mistakes)


def _contents(file: Path, experiment: Experiment | None) -> tuple[list[TransferFunction], list[Finding]]:
    """Return the functions of a file, and the findings; another platform's file is read as its experiment."""
    from nrp_core.checks.code.declarations import Declarations
    from nrp_core.experiment.making.maker import LISTERS, maker_of
    from nrp_core.experiment.model.collector import Collector

    if experiment is None:
        listings, findings = [LISTERS.load(file.suffix)(file)], []
    else:
        collector = Collector(experiment.source)
        listings = list(maker_of(experiment).listings(experiment, collector))
        findings = collector.findings
    read = [Declarations(listing) for listing in listings]
    functions = [one.function for each in read for one in each.functions]
    return functions, [*findings, *(finding for each in read for finding in each.findings)]


def _as_data(function: TransferFunction) -> dict[str, Any]:
    return {
        "name": function.name,
        "flow": function.flow.value,
        "line": function.place.line,
        "parameters": {name: str(function.mappings.get(name, "")) for name in function.parameters},
        "returns_to": None if function.topic is None else str(function.topic),
    }
