"""Tests of one value against numbers that exclude each other, or that leave nothing out."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.checks.choices import without_choice
from nrp_core.checks.declared import found_in
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP320)
def bounds_leave_a_choice(static: StaticExperiment) -> Iterator[Finding]:
    """Look for ``x < 1 and x > 5``, ``x > 1 or x < 5`` and ``x != 1 or x != 2``."""
    for source in static.sources:
        for node, message in without_choice(source.tree):
            yield found_in(source, Code.NRP320, node, message, Level.WARNING)
