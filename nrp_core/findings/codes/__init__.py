"""The codes of findings, with their explanations in one module for each topic."""

from nrp_core.findings.codes.code import Code
from nrp_core.findings.codes.explanation import Explanation, Weight

__all__ = ["Code", "Explanation", "Weight"]
