"""How robots and sensors begin."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.analysis.registry import checks_experiment
from nrp_core.analysis.study import Study
from nrp_core.clock import seconds
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP209)
def robots_have_places_of_their_own(study: Study) -> Iterator[Finding]:
    """Look for robots that begin inside each other."""
    if study.scene is None:
        return
    first: dict[tuple[float, ...], str] = {}
    for model in study.scene.models:
        if model.name not in study.experiment.world.robots:
            continue
        other = first.setdefault(tuple(model.pose.position), model.name)
        if other != model.name:
            place = study.experiment.place("world", "robots", model.name, "pose")
            message = f"'{model.name}' begins in the same place as '{other}'; give it a 'pose' of its own"
            yield place.finding(Code.NRP209, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def measurements_arrive(study: Study) -> Iterator[Finding]:
    """Look for sensors whose first message comes after the end."""
    experiment = study.experiment
    for topic, sensor in experiment.world.sensors.items():
        if sensor.delay is not None and sensor.delay >= experiment.duration:
            message = (
                f"nothing comes on '{topic}' before {seconds(sensor.delay):g} s, "
                f"and the run ends at {seconds(experiment.duration):g} s"
            )
            place = experiment.place("world", "sensors", topic, "delay")
            yield place.finding(Code.NRP248, message, Level.WARNING)
