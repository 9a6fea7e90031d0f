"""Start poses of robots, and the first messages of sensors."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP291)
def robots_start_apart(static: StaticExperiment) -> Iterator[Finding]:
    """Look for robots that start inside each other."""
    if static.scene is None:
        return
    first: dict[tuple[float, ...], str] = {}
    for model in static.scene.models:
        if model.name not in static.experiment.world.robots:
            continue
        other = first.setdefault(tuple(model.pose.position), model.name)
        if other != model.name:
            place = static.experiment.place("world", "robots", model.name, "pose")
            message = f"'{model.name}' starts in the same place as '{other}'; give it a 'pose' of its own"
            yield place.finding(Code.NRP291, message, Level.WARNING)
