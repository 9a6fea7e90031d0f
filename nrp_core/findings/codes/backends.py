"""Findings about the choice of backends, and about what a backend cannot do."""

from nrp_core.findings.codes.explanation import Explanation, Weight

NO_BACKEND = Explanation(
    "A backend that is not installed or does not load.",
    "Without it one side of the loop has no simulator.",
    "Choose a backend that `nrp backends` lists, or install the missing one.",
    "{n} backends are not available",
    Weight.ALTERED,
)

NO_CAPABILITY = Explanation(
    "The backend, or nrp-core itself, does not support a part or setting of the experiment.",
    "The part that needs it has no effect; if the simulation needs it, the run does not start.",
    "Choose a backend with this capability (`nrp backends`), or remove the part that the message names.",
    "{n} parts or settings are not supported",
    Weight.ALTERED,
)

APPROXIMATED = Explanation(
    "A property of the network that the reader of its file or the brain backend changes.",
    "The network runs, but differs from the script or file.",
    "Choose another backend or model if the property matters.",
    "{n} properties of the network are changed",
    Weight.ALTERED,
)
