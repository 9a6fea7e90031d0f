"""Check an experiment without starting a simulator."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nrp_core.experiment.find import load_experiment
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.prepare import Examination, Say, quietly
from nrp_core.findings import Finding, InvalidExperimentError


def validate(experiment: Experiment, say: Say = quietly) -> list[Finding]:
    """Return all that is wrong with an experiment that could be read."""
    return Examination(experiment, say).collector.findings


def validate_file(text: str | Path, overrides: Sequence[str] = (), say: Say = quietly) -> list[Finding]:
    """Return all that is wrong with an experiment, reading it included.

    Args:
        text: a shipped experiment, a file, or a folder with one.
        overrides: ``dotted.key=value``.
        say: told what is being done.

    Raises:
        ExperimentError: there is no such experiment.
    """
    try:
        return validate(load_experiment(text, overrides), say)
    except InvalidExperimentError as error:
        return list(error.findings)
