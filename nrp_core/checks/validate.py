"""Check an experiment, or transfer functions, without starting a simulator."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.brain.backends import brains
from nrp_core.checks.confined_functions import FileQuestion, ask, check_confined, check_functions
from nrp_core.checks.confined_network import ConfinedBuild
from nrp_core.checks.examined import (
    EXPERIMENT_CHECKS,
    Checkable,
    ExaminedExperiment,
    FunctionTopics,
    at_most,
)
from nrp_core.checks.network_summary import NetworkSummary, summary_of
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, TopicError, TransferFunctionError
from nrp_core.experiment.making.maker import LISTERS
from nrp_core.experiment.making.plan import Plan, ProgressCallback, no_progress
from nrp_core.experiment.making.prepare import make_parts, select_backend
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.reading.reader import described_by
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level
from nrp_core.findings.problems import without


def check(plan: Plan) -> list[Finding]:
    """Return probable mistakes in an experiment that can run; no function is executed."""
    summary, topics = summary_of(plan.network), FunctionTopics.of(plan.functions)
    found = check_experiment(plan, summary, topics) + check_functions(plan, summary, topics, plan.functions)
    return list(dict.fromkeys(found))


def check_experiment(
    parts: Checkable, summary: NetworkSummary, function_topics: FunctionTopics
) -> list[Finding]:
    """Return probable mistakes in an experiment, except those in its functions.

    Args:
        parts: its parts as far as they could be made.
        summary: facts about its network.
        function_topics: the topics of its functions.
    """
    from nrp_core.checks.subjects import experiments as experiments  # registers the checks

    examined = ExaminedExperiment.of(parts, summary, function_topics)
    return [at_most(finding, examined.worst) for check in EXPERIMENT_CHECKS for finding in check(examined)]


@checks_arguments("experiment")
def validate(experiment: Experiment | str | Path, progress: ProgressCallback = no_progress) -> list[Finding]:
    """Return all findings about an experiment.

    A brain script is executed in a confined process, and not again while it stays as it is. Transfer
    functions are executed in another one, for a few steps between mocks; see :mod:`nrp_core.checks.dry_run`.

    Args:
        experiment: one that could be read, or its name or path; errors of reading it are findings.
        progress: called with the name of each task as it begins.

    Raises:
        ExperimentError: it is something else.
    """
    if isinstance(experiment, str | PathLike):
        return validate_file(experiment, progress=progress)
    if not isinstance(experiment, Experiment):
        raise ExperimentError(
            "validate takes an experiment, as load_experiment('...') returns it, or its name, not "
            f"{experiment!r:.60}"
        )
    brain = select_backend(Collector(experiment.source), brains(), "brain", experiment.brain)
    limit_ns = experiment.brain.time_limit
    build = ConfinedBuild(brain, None if limit_ns is None else seconds(limit_ns))
    parts = make_parts(experiment, progress, build, build.review)
    found, topics = check_confined(parts, build.summary)
    found = [*parts.collector.findings, *found, *check_experiment(parts, build.summary, topics)]
    every = dict.fromkeys(found)
    return list(without(every, experiment.checks.ignore))


def validate_file(
    text: str | Path, overrides: Sequence[str] = (), progress: ProgressCallback = no_progress
) -> list[Finding]:
    """Return all findings about an experiment, errors of reading it included.

    Args:
        text: a shipped experiment, a file, a folder with one, or a file with transfer functions.
        overrides: ``dotted.key=value``.
        progress: called with the name of each task as it begins.
    """
    try:
        if Path(text).is_file() and Path(text).suffix in LISTERS.names():
            return validate_functions(Path(text), overrides, progress)
        return validate(load_experiment(text, overrides), progress)
    except InvalidExperimentError as error:
        return list(error.findings)
    except TransferFunctionError as error:
        return [Finding.of(error, Code.NRP210)]
    except TopicError as error:  # two parts of the world have the same topic
        return [Finding.of(error, Code.NRP212)]
    except ExperimentError as error:  # the experiment does not exist
        return [Finding.of(error, Code.NRP204)]


def validate_functions(
    path: Path, overrides: Sequence[str] = (), progress: ProgressCallback = no_progress
) -> list[Finding]:
    """Return all findings about a file with transfer functions, and the brain and body that it may name.

    Raises:
        ExperimentError: it cannot be read.
    """
    experiment = described_by(path, overrides)
    if experiment is not None:
        return validate(experiment, progress)
    found, _ = ask(FileQuestion(path))
    return [*found, *(_in_vain(path, override) for override in overrides)]


def _in_vain(path: Path, override: str) -> Finding:
    message = f"'{override}' has no effect on a file of functions alone; check the experiment that uses it"
    return Finding(Code.NRP202, message, Level.WARNING, path)


def refined(
    error: InvalidExperimentError, text: str | Path, overrides: Sequence[str] = ()
) -> InvalidExperimentError:
    """Return the findings of :func:`validate_file` for an experiment that failed to start.

    Args:
        error: the error of the run.
        text: the experiment, as of :func:`validate_file`.
        overrides: as of :func:`validate_file`.
    """
    found = validate_file(text, overrides)
    known = [finding for finding in found if finding.level is Level.ERROR]
    said = {(finding.path, key) for finding in known for key in (finding.line, finding.message)}
    others = (
        finding
        for finding in error.findings
        if (finding.path, finding.line) not in said and (finding.path, finding.message) not in said
    )
    warnings = (finding for finding in found if finding.level is Level.WARNING)  # often their causes
    return InvalidExperimentError(dict.fromkeys([*known, *others, *warnings]))
