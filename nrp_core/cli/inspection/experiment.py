"""``nrp inspect`` of an experiment; none of its code is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nrp_core.cli.failure import INVALID, complain
from nrp_core.cli.output import document
from nrp_core.clock import seconds

if TYPE_CHECKING:
    from nrp_core.experiment.making.maker import Parameters
    from nrp_core.experiment.model.experiment import Experiment
    from nrp_core.findings import Finding


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
        "parameters": parameters.as_data(),
    }


def _lines(experiment: Experiment, parameters: Parameters) -> Iterator[str]:
    name = typer.style(experiment.name, bold=True)
    brain, world = experiment.brain, experiment.world
    yield f"{name}: {seconds(experiment.duration):g} s, seed {experiment.seed}"
    if experiment.description:
        yield f"  {experiment.description}"
    yield f"  brain: {brain.model.name} in {brain.backend}"
    yield from _parameters("parameter", parameters.brain)
    robots = ", ".join(f"{name} ({robot.model.name})" for name, robot in world.robots.items()) or "no robot"
    room = world.scene.name if world.scene else "its own room"
    yield f"  world: {room} in {world.backend}, {robots}"
    if experiment.transfer_functions:
        yield f"  transfer functions: {', '.join(path.name for path in experiment.transfer_functions)}"
    yield from _parameters("parameter", parameters.functions)


def _parameters(label: str, parameters: Any) -> Iterator[str]:
    for one in parameters.values():
        yield f"    {label} {one}"
