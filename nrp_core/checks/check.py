"""The checks: each a small function, registered here."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, TypeAlias

from nrp_core.findings import Finding

if TYPE_CHECKING:
    from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment

OfFunction: TypeAlias = "Callable[[CheckedFunction], Iterator[Finding]]"
OfExperiment: TypeAlias = "Callable[[StaticExperiment], Iterator[Finding]]"

CHECKS: list[OfExperiment] = []
"""All checks, in the order in which they run."""


def checks_function(check: OfFunction) -> OfFunction:
    """Register a check of one transfer function."""

    def check_all(static: StaticExperiment) -> Iterator[Finding]:
        for function in static.functions:
            yield from check(function)

    CHECKS.append(check_all)
    return check


def checks_experiment(check: OfExperiment) -> OfExperiment:
    """Register a check of a whole experiment."""
    CHECKS.append(check)
    return check
