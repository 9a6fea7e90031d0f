"""Start poses of robots, and the first messages of sensors."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.clock import seconds
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


@checks_experiment(Code.NRP248)
def measurements_arrive(static: StaticExperiment) -> Iterator[Finding]:
    """Look for sensors whose first message comes after the end of the run."""
    experiment = static.experiment
    for topic, sensor in experiment.world.sensors.items():
        if sensor.drop_out == 1:
            place = experiment.place("world", "sensors", topic, "drop_out")
            message = f"no message comes on '{topic}': a drop_out of 1 loses all of them"
            yield place.finding(Code.NRP248, message, Level.WARNING)
        if sensor.delay is not None and sensor.delay >= experiment.duration:
            message = (
                f"no message comes on '{topic}' before {seconds(sensor.delay):g} s, "
                f"and the run ends at {seconds(experiment.duration):g} s"
            )
            place = experiment.place("world", "sensors", topic, "delay")
            yield place.finding(Code.NRP248, message, Level.WARNING)
