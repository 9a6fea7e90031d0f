"""``nrp inspect`` of experiments and transfer functions, ``nrp explain`` of parameters; no code is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.options import refuse_given
from nrp_core.cli.output import INVALID, complain, document, warn
from nrp_core.clock import seconds

if TYPE_CHECKING:
    from nrp_core.dsl.functions import TransferFunction
    from nrp_core.experiment.making.maker import Parameters, ParameterValue
    from nrp_core.experiment.model.experiment import Experiment
    from nrp_core.findings import Finding

_KEYS = {"brain": "brain.parameters", "functions": "function_parameters"}
_WHERE = {"brain": ", in the brain script", "functions": ", in the transfer functions"}


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
        warn(str(finding))


def declared_parameters(file: Path) -> tuple[list[ParameterValue], list[Finding]]:
    """Return the parameters that a script declares, with their defaults, and declarations that are wrong."""
    from nrp_core.experiment.making.maker import ParameterValue
    from nrp_core.findings import Code, Finding
    from nrp_core.parameters import BRAIN, FUNCTIONS, Declared, read_parameters

    declared = Declared()
    for kind in (FUNCTIONS, BRAIN):
        read_parameters(file, kind, into=declared)
    # a call may be read as one of both kinds
    mistakes = dict.fromkeys(Finding.of(one, Code.NRP202) for one in declared.mistakes)
    return [ParameterValue(one, one.default) for one in declared.parameters.values()], list(mistakes)


def _contents(file: Path, experiment: Experiment | None) -> tuple[list[TransferFunction], list[Finding]]:
    """Return the functions of a file, and the findings; another platform's file is read as its experiment."""
    from nrp_core.dsl.declared import declared_functions
    from nrp_core.experiment.making.maker import LISTERS, maker_of
    from nrp_core.experiment.model.collector import Collector

    if experiment is None:
        listings, findings = [LISTERS.load(file.suffix)(file)], []
    else:
        collector = Collector(experiment.source)
        listings = list(maker_of(experiment).listings(experiment, collector))
        findings = collector.findings
    return [one.function for each in listings for one in declared_functions(each)], findings


def _as_data(function: TransferFunction) -> dict[str, Any]:
    return {
        "name": function.name,
        "flow": function.flow.value,
        "line": function.place.line,
        "parameters": {name: str(function.mappings.get(name, "")) for name in function.parameters},
        "returns_to": None if function.topic is None else str(function.topic),
    }


def explain_parameters(subject: str, wanted: str | None, overrides: Sequence[str], *, as_json: bool) -> None:
    """Print the description of a parameter, or of all.

    Args:
        subject: an experiment, a recording, a brain script or a file of functions.
        wanted: a name or a key as for ``--set``; None: all parameters.
        overrides: of the experiment.
        as_json: whether as one JSON document.

    Raises:
        ExperimentError: the subject cannot be read.
        typer.BadParameter: the parameter does not exist.
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
    from nrp_core.cli.inspect_recordings import is_recording
    from nrp_core.experiment.making.maker import ParameterValue
    from nrp_core.recording.recording import Recording

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
        """The key that sets it; only its name, if it belongs to a single file."""
        return self.name if self.side is None else f"{_KEYS[self.side]}.{self.name}"

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return {"name": self.name, "key": self.key, **self.one.as_data()}

    def lines(self) -> Iterator[str]:
        """Yield its explanation."""
        about, where = self.one.parameter, "" if self.side is None else _WHERE[self.side]
        yield f"{self.key}: {about.doc}" if about.doc else self.key
        yield ""
        yield f"  value: {about.value_text(self.one.value)}"
        yield f"  set by: {self.one.set_by or 'nothing; it is the default'}"
        yield f"  default: {about.value_text(about.default)}"
        yield f"  valid: {about.kind}{', ' if about.range else ''}{about.range}"
        yield f"  declared: {about.place}{where}"


def is_experiment(path: Path) -> bool:
    """Return whether a path is an experiment: a file in a known format, a folder with one, or a name."""
    from nrp_core.experiment.reading.find import READERS
    from nrp_core.recording.layout import MCAP_NAME

    if path.is_dir():
        return not (path / MCAP_NAME).is_file()
    return path.suffix in READERS.names() or not path.exists()


def inspect_experiment(text: str, overrides: Sequence[str], *, as_json: bool) -> None:
    """Print the parts of an experiment and the parameters of its scripts.

    Raises:
        ExperimentError: the experiment does not exist or is not valid.
    """
    from nrp_core.findings import has_errors

    experiment, parameters, findings = checked_parameters(text, overrides)
    if as_json:
        document({**_data(experiment, parameters), "findings": [one.to_dict() for one in findings]})
    else:
        for line in _lines(experiment, parameters):
            typer.echo(line)
        for finding in findings:
            complain(str(finding))
    if has_errors(findings):
        raise typer.Exit(INVALID)


def checked_parameters(text: str, overrides: Sequence[str]) -> tuple[Experiment, Parameters, list[Finding]]:
    """Return an experiment, its parameters, and the findings about these; no script is executed.

    Raises:
        ExperimentError: the experiment does not exist or is not valid.
    """
    from nrp_core.experiment.making.maker import with_parameters
    from nrp_core.experiment.model.collector import Collector
    from nrp_core.experiment.reading.find import load_experiment

    experiment = load_experiment(text, overrides)
    collector = Collector(experiment.source)
    parameters = with_parameters(experiment, collector)[1]
    return experiment, parameters, collector.findings


def _data(experiment: Experiment, parameters: Parameters) -> dict[str, Any]:
    return {
        "experiment": experiment.name,
        "description": experiment.description,
        "file": experiment.source.place.path,
        "duration_s": seconds(experiment.duration),
        "seed": experiment.seed,
        "brain": {"backend": experiment.brain.backend, "model": experiment.brain.model},
        "world": {
            "backend": experiment.world.backend,
            "scene": experiment.world.scene,
            "robots": {name: robot.model for name, robot in experiment.world.robots.items()},
        },
        "transfer_functions": experiment.transfer_functions,
        "events": list(experiment.events),
        "criteria": list(experiment.criteria),
        "parameters": parameters.as_data(),
    }


def _lines(experiment: Experiment, parameters: Parameters) -> Iterator[str]:
    name = typer.style(experiment.name, bold=True)
    brain, world = experiment.brain, experiment.world
    yield f"{name}: {seconds(experiment.duration):g} s, seed {experiment.seed}"
    if experiment.description:
        yield f"  {experiment.description}"
    models = ", ".join(f"{name} {path.name}".strip() for name, path in brain.files.items())
    yield f"  brain: {models} in {brain.backend}"
    yield from _parameters("parameter", parameters.brain)
    files = {
        name: robot.model.name if robot.model else "in the scene" for name, robot in world.robots.items()
    }
    robots = ", ".join(f"{name} ({file})" for name, file in files.items()) or "no robot"
    room = world.scene.name if world.scene else "its own room"
    yield f"  world: {room} in {world.backend}, {robots}"
    if experiment.transfer_functions:
        yield f"  transfer functions: {', '.join(path.name for path in experiment.transfer_functions)}"
    yield from _parameters("parameter", parameters.functions)
    for label, names in (("events", experiment.events), ("criteria", experiment.criteria)):
        if names:
            yield f"  {label}: {', '.join(names)}"


def _parameters(label: str, parameters: Any) -> Iterator[str]:
    for name, one in parameters.items():
        yield f"    {label} {''.join(name.rpartition('.')[:2])}{one}"
