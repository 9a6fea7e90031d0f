"""What a check doubts about an experiment: as problems of its run, or told before many runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Final

from nrp_core.brain.network.data import Network
from nrp_core.checks.network import ChildBuilder
from nrp_core.checks.study import Study, at_most
from nrp_core.checks.validate import findings_of
from nrp_core.clock import from_seconds
from nrp_core.errors import NrpError
from nrp_core.experiment.making.prepare import (
    Plan,
    ProgressCallback,
    building,
    built_in_time,
    no_progress,
)
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, Level, Weight
from nrp_core.findings.problems import grouped, is_doubt, ordered


def checked_run(
    experiment: Experiment,
    read_again: Callable[[], Experiment],
    progress: ProgressCallback = no_progress,
    *,
    until_s: float | None = None,
) -> Run:
    """Open a run whose problems include the warnings of :func:`~nrp_core.checks.validate.validate`.

    The check uses the network of the run, so no script is executed twice.

    Args:
        experiment: the experiment.
        read_again: returns it anew, for the check; the parts of an experiment may belong to its run.
        progress: called with the name of each task as it begins.
        until_s: the end of the run, if it is not that of the experiment, s.

    Raises:
        BackendError, InvalidExperimentError: as of :class:`.Run`.
    """
    made: list[Network] = []
    as_long = _lasting(read_again, until_s)

    def build(make: Callable[[], Network]) -> Network:
        progress(building(experiment))
        made[:] = [built_in_time(experiment, make)]
        return made[0]

    def with_doubts(plan: Plan) -> Plan:
        progress("checking the experiment")
        found = _doubts(as_long, _Made(made.pop() if made else plan.network))
        return replace(plan, warnings=(*plan.warnings, *new_doubts(found, plan.warnings)))

    return Run(experiment, progress, revise=with_doubts, build=build)


def doubts_of(read: Callable[[], Experiment], until_s: float | None = None) -> list[Finding]:
    """Return what a check doubts about an experiment whose runs are made elsewhere, as in other processes.

    A brain script is executed in a confined process, and not again while it stays as it is.

    Args:
        read: returns the experiment.
        until_s: the end of its runs, if it is not that of the experiment, s.
    """
    found = (at_most(one, Level.WARNING) for one in _doubts(_lasting(read, until_s), None))
    return [finding for finding in found if is_doubt(finding) and finding.code is not _OF_COMPARISONS]


_OF_COMPARISONS: Final = Code.NRP215
"""What the section 'comparison' cannot vary, which a run does not read."""
_TOLD: set[tuple[str, Finding]] = set()
"""What this process has told about experiments that it opens."""


def announcement(name: str, problems: Iterable[Finding]) -> str:
    """Return a text about what is missing from an experiment or doubted; empty if this process has told it.

    Args:
        name: the name of the experiment.
        problems: of a run at its beginning, or as of :func:`doubts_of`.
    """
    new = [one for one in ordered(problems) if is_doubt(one) and (name, one) not in _TOLD]
    _TOLD.update((name, one) for one in new)
    if not new:
        return ""
    told = [group.headline if group.is_counted else str(group.findings[0]) for group in grouped(new)]
    return "\n  ".join([f"nrp validate warns about the experiment '{name}':", *told])


def _lasting(read: Callable[[], Experiment], until_s: float | None) -> Callable[[], Experiment]:
    """Return a reader of an experiment that lasts as long as a run that goes beyond its end."""

    def as_long() -> Experiment:
        experiment = read()
        lasts = experiment.duration if until_s is None else max(experiment.duration, from_seconds(until_s))
        return experiment.model_copy(update={"duration": lasts})

    return as_long


class _Made(ChildBuilder):
    """Returns a network that was made before."""

    def __init__(self, network: Network) -> None:
        super().__init__(None, None)
        self._network = network

    def __call__(self, make: Callable[[], Network]) -> Network:
        return self.described(self._network)


def _doubts(read_again: Callable[[], Experiment], build: ChildBuilder | None) -> list[Finding]:
    """Return the findings of a check; one that fails is a finding itself, because the run can do without."""
    try:
        return findings_of(Study(read_again(), no_progress, build))
    except NrpError as error:
        message = f"the check of the experiment ended early: {error}"
    except Exception as error:  # noqa: BLE001  a flaw of a check must not keep a run from starting
        message = f"the check of the experiment failed: {type(error).__name__}: {error}"
    return [Finding(Code.NRP239, message, Level.WARNING)]


def new_doubts(found: Iterable[Finding], known: Iterable[Finding]) -> Iterator[Finding]:
    """Yield what a check doubts and was not said before; the run itself shows what is missing from it."""
    said = [finding.message for finding in known]
    for finding in found:
        doubt = at_most(finding, Level.WARNING)
        is_new = doubt.level is Level.WARNING and doubt.weight is not Weight.INCOMPLETE
        is_new &= doubt.code is not _OF_COMPARISONS
        if is_new and not any(doubt.message in message for message in said):
            yield doubt
