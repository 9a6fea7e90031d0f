"""Findings about experiments of the Neurorobotics Platform."""

from nrp_core.findings.codes.explanation import Explanation, Weight

CONVERTED = Explanation(
    "A part of an experiment of the Neurorobotics Platform is converted, replaced or omitted.",
    "The rest runs; the named part may behave differently than on that platform.",
    "No action is needed unless it matters; docs/reference/nrp-experiments.md lists the conversions.",
    "{n} parts of the experiment are converted",
    Weight.REMARK,
)
