"""Findings about experiments of the Neurorobotics Platform."""

from nrp_core.findings.codes.explanation import Explanation, Weight

CONVERTED = Explanation(
    "A part of an experiment of the Neurorobotics Platform is converted, replaced or omitted.",
    "The rest runs; the named part may behave differently than on that platform.",
    "No action is needed unless it matters; docs/reference/nrp-experiments.md lists the conversions.",
    "{n} parts of the experiment are converted",
    Weight.REMARK,
)

RESOURCE_MISSING = Explanation(
    "A module, package or file of the experiment is missing.",
    "Code that uses it fails or is skipped.",
    "Install the module, or put the file where the experiment names it.",
    "{n} modules or files are missing",
    Weight.ALTERED,
)

NOT_SUPPORTED = Explanation(
    "An element or setting of the Neurorobotics Platform is not supported.",
    "The element is ignored; the rest of the experiment runs.",
    "No action is needed unless it matters; docs/reference/nrp-experiments.md lists the conversions.",
    "{n} elements or settings are not supported",
    Weight.ALTERED,
)
