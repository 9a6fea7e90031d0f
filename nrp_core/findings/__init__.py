"""Findings: what checks find in an experiment, each with a code and a place."""

from nrp_core.findings.codes import Code
from nrp_core.findings.finding import Finding, InvalidExperimentError, Level, has_errors

__all__ = ["Code", "Finding", "InvalidExperimentError", "Level", "has_errors"]
