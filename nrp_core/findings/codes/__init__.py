"""The codes of findings, with their explanations in one module for each topic."""

from nrp_core.findings.codes.explanation import Explanation, Weight
from nrp_core.findings.codes.index import Code

__all__ = ["Code", "Explanation", "Weight"]
