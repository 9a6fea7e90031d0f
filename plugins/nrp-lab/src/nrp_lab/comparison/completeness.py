"""Incomplete runs, which a comparison reports first."""

from __future__ import annotations

from collections.abc import Mapping

from nrp_core._support.words import first_of
from nrp_core.experiment.running.judgement import recorded_judgement
from nrp_core.findings import Weight
from nrp_lab.comparison.signals import RunSignals

_MOST_NAMED = 3


def incompleteness(runs: Mapping[str, RunSignals]) -> list[str]:
    """Return a sentence for each reason why runs are not complete, with the runs that it concerns.

    Args:
        runs: the runs by their names.
    """
    concerned: dict[str, list[str]] = {}
    for name, run in runs.items():
        if reason := missing_from(run):
            concerned.setdefault(reason, []).append(name)
    return [f"not complete: {first_of(names, _MOST_NAMED)}: {reason}" for reason, names in concerned.items()]


def missing_from(run: RunSignals) -> str:
    """Return the reasons why a recorded run is not complete; an empty text if it is complete."""
    judgement = recorded_judgement(run.run, run.end_s)
    groups = judgement.groups if judgement else []
    return "; ".join(group.headline for group in groups if group.weight is Weight.INCOMPLETE)
