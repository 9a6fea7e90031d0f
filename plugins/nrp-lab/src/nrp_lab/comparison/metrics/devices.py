"""The signals between brain and body: mean values of devices over the run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nrp_core.recording.layout import Role
from nrp_lab.comparison.metrics.base import ScalarMetric
from nrp_lab.comparison.signals import RunSignals


class DeviceValues(ScalarMetric):
    """The mean of each device's value over time, in the device's own unit."""

    name, title = "devices", "Device values (mean)"

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        series = run.numbers.with_role(Role.SINK, Role.SOURCE)
        means = {one.name.removeprefix("/brain/devices/"): run.held(one) for one in series}
        return {
            name: float(np.nanmean(values)) if np.isfinite(values).any() else None
            for name, values in means.items()
        }

    def resolution(self, run: RunSignals) -> float:
        return 1e-9
