"""Check an experiment without starting a simulator or executing a transfer function."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nrp_core.analysis import checks as checks  # registers them
from nrp_core.analysis.registry import CHECKS
from nrp_core.analysis.study import Study, at_most
from nrp_core.experiment.find import load_experiment
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.prepare import Say, quietly
from nrp_core.findings import Finding, InvalidExperimentError, Level


def validate(experiment: Experiment, say: Say = quietly) -> list[Finding]:
    """Return all that is wrong with an experiment that could be read, and what is worth knowing of it."""
    study = Study(experiment, say)
    worst = Level.ERROR if experiment.strict else Level.WARNING
    found = [at_most(finding, worst) for check in CHECKS for finding in check.run(study)]
    return list(dict.fromkeys([*study.collector.findings, *found]))


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
