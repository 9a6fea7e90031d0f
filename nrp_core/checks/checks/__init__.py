"""The checks, one module for each subject; importing this registers them."""

from nrp_core.checks.checks import (
    capabilities,
    incoming_messages,
    lost_state,
    names,
    operations,
    outgoing_messages,
    plausibility,
    populations,
    reproducibility,
    sensors,
    time_conditions,
    units,
    wiring,
)

__all__ = [
    "capabilities",
    "incoming_messages",
    "lost_state",
    "names",
    "operations",
    "outgoing_messages",
    "plausibility",
    "populations",
    "reproducibility",
    "sensors",
    "time_conditions",
    "units",
    "wiring",
]
