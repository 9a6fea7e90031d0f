"""``nrp validate``."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from nrp_core.cli.options import (
    BrainName,
    ExperimentName,
    Ignore,
    Json,
    Models,
    Overrides,
    Trust,
    Verbose,
    WorldName,
    ignored_codes,
    overrides_of,
)
from nrp_core.cli.output import INVALID, NO_BACKEND, document

if TYPE_CHECKING:
    from nrp_core.findings import Finding


class FindingFormat(StrEnum):
    """The output formats."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    GITHUB = "github"


def validate(
    experiment: ExperimentName,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    models: Models = None,
    format: Annotated[  # noqa: A002  the name of the option
        FindingFormat, typer.Option("--format", envvar="NRP_FORMAT", help="The output format.")
    ] = FindingFormat.TEXT,
    ignore: Ignore = None,
    trust: Trust = False,
    verbose: Verbose = False,
    json: Json = False,
) -> None:
    """Check an experiment without starting a simulator.

    EXPERIMENT may also be a file with transfer functions. A BIBI file of the Neurorobotics Platform is
    checked with its brain and robots, as part of the experiment beside it that names it.

    The brain script and the transfer functions are executed, each for at most 20 s, in processes without
    network that can write only temporary files. The functions run for five steps between mocks. Where the
    system does not allow that (nrp doctor), nothing is executed without --trust.
    """
    from nrp_core._support.confinement import trusting
    from nrp_core.checks.validate import validate_file
    from nrp_core.findings.problems import without

    if json and format not in (FindingFormat.TEXT, FindingFormat.JSON):
        raise typer.BadParameter(
            f"--json and --format {format.value} contradict each other", param_hint="--json"
        )
    given = overrides_of(overrides, brain=brain, world=world, models=models)
    with trusting(trust):
        findings = list(without(validate_file(experiment, given), ignored_codes(ignore)))
    code = _exit_code(findings)
    _write(findings, FindingFormat.JSON if json else format, is_valid=code == 0, details=verbose)
    raise typer.Exit(code)


def _write(findings: list[Finding], form: FindingFormat, *, is_valid: bool, details: bool) -> None:
    from nrp_core.cli.finding_formats import github, sarif
    from nrp_core.cli.summary import print_findings

    if form is FindingFormat.JSON:
        document({"valid": is_valid, "findings": [finding.to_dict() for finding in findings]})
    elif form is FindingFormat.SARIF:
        document(sarif(findings))
    elif form is FindingFormat.GITHUB:
        for line in github(findings):
            typer.echo(line)
    else:
        print_findings(findings, details=details)
        typer.echo(_verdict(findings) if is_valid else "not valid")


def _verdict(findings: list[Finding]) -> str:
    """Return the verdict on an experiment without errors."""
    from nrp_core.findings import Code

    is_partial = any(one.code is Code.NRP239 for one in findings)
    return "valid, but not checked in full (NRP239)" if is_partial else "valid"


def _exit_code(findings: list[Finding]) -> int:
    """Return 0 without errors, 4 if every error is a missing backend, 3 otherwise."""
    from nrp_core.findings import Code, Level

    wrong = {finding.code for finding in findings if finding.level is Level.ERROR}
    if not wrong:
        return 0
    return NO_BACKEND if wrong == {Code.NRP205} else INVALID
