"""Warnings of checks, attached to a run or printed once before a sweep."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from nrp_core.checks.examined import at_most
from nrp_core.checks.validate import check, validate
from nrp_core.clock import from_seconds
from nrp_core.errors import NrpError
from nrp_core.experiment.making.plan import Plan
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level, Weight
from nrp_core.findings.problems import is_warning, lines_of, ordered

_ANNOUNCED: set[tuple[str, Finding]] = set()
"""What this process has announced about experiments that it opens."""


def with_warnings(plan: Plan, until_s: float | None = None) -> Plan:
    """Return a plan whose warnings include those of the checks.

    Args:
        plan: the plan of a run.
        until_s: the end of the run, if it is not that of the experiment, s.
    """
    as_long = replace(plan, experiment=_lasting(plan.experiment, until_s))
    found = _guarded(lambda: check(as_long))
    return replace(plan, warnings=(*plan.warnings, *new_warnings(found, plan.warnings)))


def experiment_warnings(read: Callable[[], Experiment], until_s: float | None = None) -> list[Finding]:
    """Return the warnings about an experiment whose runs are made elsewhere, as in other processes.

    Args:
        read: returns the experiment.
        until_s: the end of its runs, if it is not that of the experiment, s.
    """
    found = _guarded(lambda: validate(_lasting(read(), until_s)))
    warnings = (at_most(one, Level.WARNING) for one in found)
    return [finding for finding in warnings if is_warning(finding)]


def announcement(name: str, problems: Iterable[Finding]) -> str:
    """Return a text on missing parts and probable mistakes of an experiment; empty if all were announced.

    Args:
        name: the name of the experiment.
        problems: of a run at its beginning, or as of :func:`experiment_warnings`.
    """
    new = [one for one in ordered(problems) if is_warning(one) and (name, one) not in _ANNOUNCED]
    _ANNOUNCED.update((name, one) for one in new)
    if not new:
        return ""
    lines = [line for _weight, line in lines_of(new, places=True)]
    return "\n  ".join([f"nrp validate warns about the experiment '{name}':", *lines])


def new_warnings(found: Iterable[Finding], known: Iterable[Finding]) -> Iterator[Finding]:
    """Yield the new warnings; the run itself shows its missing parts."""
    messages = [finding.message for finding in known]
    for finding in found:
        warning = at_most(finding, Level.WARNING)
        is_new = warning.level is Level.WARNING and warning.weight is not Weight.INCOMPLETE
        if is_new and not any(warning.message in message for message in messages):
            yield warning


def _lasting(experiment: Experiment, until_s: float | None) -> Experiment:
    """Return the experiment with the duration of a run that continues beyond its end."""
    lasts = experiment.duration if until_s is None else max(experiment.duration, from_seconds(until_s))
    return experiment.model_copy(update={"duration": lasts})


def _guarded(work: Callable[[], list[Finding]]) -> list[Finding]:
    """Return the findings of a check; one that fails is a finding itself, because the run can do without."""
    try:
        return work()
    except NrpError as error:
        message = f"the check of the experiment ended early: {error}"
    except Exception as error:  # noqa: BLE001  a flaw of a check must not keep a run from starting
        message = f"the check of the experiment failed: {type(error).__name__}: {error}"
    return [Finding(Code.NRP239, message, Level.WARNING)]
