"""The checks, one module for each subject; importing this registers them."""

from nrp_core.checks.subjects import (
    bounds,
    capabilities,
    drives,
    lengths,
    lost_state,
    messages,
    names,
    operations,
    populations,
    sensor_visibility,
    side_effects,
    start_poses,
    time_conditions,
    units,
    wiring,
)

__all__ = [
    "bounds",
    "capabilities",
    "drives",
    "lengths",
    "lost_state",
    "messages",
    "names",
    "operations",
    "populations",
    "sensor_visibility",
    "side_effects",
    "start_poses",
    "time_conditions",
    "units",
    "wiring",
]
