"""``nrp validate``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from nrp_core.cli.failure import INVALID, NO_BACKEND, complain
from nrp_core.cli.options import BrainName, ExperimentName, Json, Models, Overrides, WorldName, overrides_of
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core.findings import Finding

_COLORS = {"error": "red", "warning": "yellow", "note": "blue"}


def validate(
    experiment: ExperimentName,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    models: Models = None,
    json: Json = False,
) -> None:
    """Check an experiment without starting a simulator."""
    from nrp_core.experiment.validate import validate_file

    findings = validate_file(experiment, overrides_of(overrides, brain=brain, world=world, models=models))
    code = _exit_code(findings)
    if json:
        document({"valid": code == 0, "findings": [finding.to_dict() for finding in findings]})
    else:
        for finding in findings:
            complain(str(finding), label=str(finding.level), color=_COLORS[str(finding.level)])
        typer.echo("valid" if code == 0 else "not valid")
    raise typer.Exit(code)


def _exit_code(findings: list[Finding]) -> int:
    """Return 4 if all that is wrong is a backend that is missing, 3 if anything else is."""
    from nrp_core.findings import Code, Level

    wrong = {finding.code for finding in findings if finding.level is Level.ERROR}
    if not wrong:
        return 0
    return NO_BACKEND if wrong == {Code.NRP205} else INVALID
