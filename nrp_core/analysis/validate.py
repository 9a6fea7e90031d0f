"""Check an experiment without starting a simulator or executing a transfer function."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nrp_core.analysis import checks as checks  # registers them
from nrp_core.analysis.registry import CHECKS
from nrp_core.analysis.study import Study, at_most
from nrp_core.errors import ExperimentError
from nrp_core.experiment.making.prepare import ProgressCallback, no_progress
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level


def validate(experiment: Experiment, progress: ProgressCallback = no_progress) -> list[Finding]:
    """Return all that is wrong with an experiment that could be read, and what is worth knowing of it."""
    study = Study(experiment, progress)
    worst = Level.ERROR if experiment.strict else Level.WARNING
    found = [at_most(finding, worst) for check in CHECKS for finding in check.run(study)]
    return list(dict.fromkeys([*study.collector.findings, *found]))


def validate_file(
    text: str | Path, overrides: Sequence[str] = (), progress: ProgressCallback = no_progress
) -> list[Finding]:
    """Return all that is wrong with an experiment, reading it included.

    Args:
        text: a shipped experiment, a file, or a folder with one.
        overrides: ``dotted.key=value``.
        progress: called with the name of each task as it begins.
    """
    try:
        return validate(load_experiment(text, overrides), progress)
    except InvalidExperimentError as error:
        return list(error.findings)
    except ExperimentError as error:  # there is no such experiment
        return [Finding.of(error, Code.NRP204)]


def refined(
    error: InvalidExperimentError, text: str | Path, overrides: Sequence[str] = ()
) -> InvalidExperimentError:
    """Return what keeps an experiment from running in the words of :func:`validate_file`, which knows more.

    Args:
        error: what a run ended with before it began.
        text: the experiment, as of :func:`validate_file`.
        overrides: likewise.
    """
    known = [finding for finding in validate_file(text, overrides) if finding.level is Level.ERROR]
    said = {(finding.path, key) for finding in known for key in (finding.line, finding.message)}
    others = (
        finding
        for finding in error.findings
        if (finding.path, finding.line) not in said and (finding.path, finding.message) not in said
    )
    return InvalidExperimentError([*known, *others])
