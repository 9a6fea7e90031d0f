"""The codes of findings, with their explanations in one module for each topic, as ``index.py`` lists them.

An explanation says why, how to fix it, and the line of a summary. The message of one finding names the thing,
so it stands where the finding is made; :mod:`nrp_core.findings.refusals` has the words that several share.
"""

from nrp_core.findings.codes.explanation import Explanation, Weight
from nrp_core.findings.codes.index import Code

__all__ = ["Code", "Explanation", "Weight"]
