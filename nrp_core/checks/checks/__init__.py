"""The checks, one module for each subject; importing this registers them."""

from nrp_core.checks.checks import (
    capabilities,
    device_weights,
    drives,
    incoming_messages,
    lengths,
    lost_state,
    names,
    operations,
    outgoing_messages,
    populations,
    reproducibility,
    sensor_visibility,
    start_poses,
    time_conditions,
    units,
    wiring,
)

__all__ = [
    "capabilities",
    "device_weights",
    "drives",
    "incoming_messages",
    "lengths",
    "lost_state",
    "names",
    "operations",
    "outgoing_messages",
    "populations",
    "reproducibility",
    "sensor_visibility",
    "start_poses",
    "time_conditions",
    "units",
    "wiring",
]
