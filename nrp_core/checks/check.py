"""The checks: each a small function, registered with the codes of its findings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from nrp_core.findings import Code, Finding

if TYPE_CHECKING:
    from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment

OfFunction: TypeAlias = "Callable[[CheckedFunction], Iterator[Finding]]"
OfExperiment: TypeAlias = "Callable[[StaticExperiment], Iterator[Finding]]"


@dataclass(frozen=True, slots=True)
class Check:
    """A check.

    Args:
        codes: the codes of its findings.
        of_function: checks one transfer function; or
        of_experiment: checks a whole experiment.
    """

    codes: tuple[Code, ...]
    of_function: OfFunction | None = None
    of_experiment: OfExperiment | None = None

    def run(self, static: StaticExperiment) -> Iterator[Finding]:
        """Yield its findings in an experiment."""
        if self.of_experiment is not None:
            yield from self.of_experiment(static)
        if self.of_function is not None:
            for function in static.functions:
                yield from self.of_function(function)


CHECKS: list[Check] = []
"""All checks, in the order in which they run."""


def checks_function(*codes: Code) -> Callable[[OfFunction], OfFunction]:
    """Register a check of one transfer function."""

    def registered(check: OfFunction) -> OfFunction:
        CHECKS.append(Check(codes, of_function=check))
        return check

    return registered


def checks_experiment(*codes: Code) -> Callable[[OfExperiment], OfExperiment]:
    """Register a check of a whole experiment."""

    def registered(check: OfExperiment) -> OfExperiment:
        CHECKS.append(Check(codes, of_experiment=check))
        return check

    return registered
