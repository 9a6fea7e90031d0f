"""Findings of checks, engines and runs, each with a code, a message and a place."""

from nrp_core.findings.codes import Code, Weight
from nrp_core.findings.finding import Finding, InvalidExperimentError, Level, has_errors, headline
from nrp_core.findings.findings import Findings, merged

__all__ = [
    "Code",
    "Finding",
    "Findings",
    "InvalidExperimentError",
    "Level",
    "Weight",
    "has_errors",
    "headline",
    "merged",
]
