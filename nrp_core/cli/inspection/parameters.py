"""``nrp explain`` of the parameters of an experiment, a recording or a file; none of its code is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.failure import INVALID, complain
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core.experiment.making.maker import ParameterValue
    from nrp_core.findings import Finding

_KEYS = {"brain": "brain.parameters", "functions": "function_parameters"}
_OF = {"brain": ", in the brain script", "functions": ", in the transfer functions"}


def explain_parameters(subject: str, wanted: str | None, overrides: Sequence[str], *, as_json: bool) -> None:
    """Print what is known of a parameter, or of all.

    Args:
        subject: an experiment, a recording, a brain script or a file of functions.
        wanted: a name, or a key as for ``--set``; None: all parameters.
        overrides: of the experiment.
        as_json: whether as one JSON document.

    Raises:
        ExperimentError: the subject cannot be read.
        typer.BadParameter: there is no such parameter.
    """
    from nrp_core.errors import did_you_mean
    from nrp_core.findings import has_errors

    known, findings = parameters_of(subject, overrides)
    for finding in findings:
        complain(str(finding))
    found = [one for one in known if wanted in (None, one.name, one.key)]
    if wanted is not None and not found:
        hint = did_you_mean(wanted, (one.key if "." in wanted else one.name for one in known))
        raise typer.BadParameter(f"{subject} has no parameter '{wanted}'{hint}", param_hint="PARAMETER")
    if as_json:
        document({"parameters": [one.as_data() for one in found]})
    elif found:
        typer.echo("\n\n".join("\n".join(one.lines()) for one in found))
    else:
        typer.echo(f"{subject} has no parameters")
    if has_errors(findings):
        raise typer.Exit(INVALID)


def parameters_of(subject: str, overrides: Sequence[str] = ()) -> tuple[list[Explained], list[Finding]]:
    """Return all parameters of an experiment, a recording or a file, and the findings about them.

    Raises:
        ExperimentError: the subject cannot be read.
    """
    from nrp_core.cli.inspection.experiment import checked_parameters, is_experiment
    from nrp_core.cli.inspection.functions import are_functions, declared_parameters
    from nrp_core.cli.inspection.recording import is_recording
    from nrp_core.experiment.making.maker import ParameterValue
    from nrp_core.recording.reading.recording import Recording

    path = Path(subject)
    if is_recording(path):
        if overrides:
            raise typer.BadParameter("a recording has the settings of its run; omit this", param_hint="-s")
        recorded = Recording(path).run.get("parameters") or {}
        return [
            Explained(ParameterValue.of_data(name, one), side)
            for side, all_ in recorded.items()
            for name, one in all_.items()
        ], []
    if not is_experiment(path) and are_functions(path):
        values, findings = declared_parameters(path)
        return [Explained(one) for one in values], findings
    _, parameters, findings = checked_parameters(subject, overrides)
    sides = {"brain": parameters.brain, "functions": parameters.functions}
    return [Explained(one, side) for side, all_ in sides.items() for one in all_.values()], findings


@dataclass(frozen=True, slots=True)
class Explained:
    """A parameter and its side of the experiment.

    Args:
        one: the parameter with its value.
        side: ``brain`` or ``functions``; None: of a file alone.
    """

    one: ParameterValue
    side: str | None = None

    @property
    def name(self) -> str:
        """Its name."""
        return self.one.parameter.name

    @property
    def key(self) -> str:
        """The key that sets it; its name, if it belongs to a file alone."""
        return self.name if self.side is None else f"{_KEYS[self.side]}.{self.name}"

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return {"name": self.name, "key": self.key, **self.one.as_data()}

    def lines(self) -> Iterator[str]:
        """Yield its explanation."""
        about, where = self.one.parameter, "" if self.side is None else _OF[self.side]
        yield f"{self.key}: {about.doc}" if about.doc else self.key
        yield ""
        yield f"  value: {about.shown(self.one.value)}"
        yield f"  set by: {self.one.set_by or 'nothing; it is the default'}"
        yield f"  default: {about.shown(about.default)}"
        yield f"  valid: {about.kind}{', ' if about.range else ''}{about.range}"
        yield f"  declared: {about.place}{where}"
