"""Settings of an experiment that are given and change nothing in it."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.dsl.functions.mappings import MapCSVRecorder
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP279)
def settings_have_an_effect(static: StaticExperiment) -> Iterator[Finding]:
    """Look for settings of images without a camera, and of CSV files without a recorder."""
    experiment = static.experiment
    for keys, message in _idle(static):
        place, found = experiment.source.nearest(keys)
        if found == keys:
            yield place.place.finding(Code.NRP279, message, Level.WARNING)


def _idle(static: StaticExperiment) -> Iterator[tuple[tuple[Key, ...], str]]:
    """Yield the keys of each setting without effect, with the message about it."""
    scene, robots = static.scene, static.experiment.world.robots
    models = {} if scene is None else {model.name: model for model in scene.models}
    sensors = [sensor for model in models.values() for link in model.links for sensor in link.sensors]
    if models.keys() >= robots.keys() and not any(sensor.views for sensor in sensors):
        for name in ("image_scale", "renderer"):
            yield ("world", "options", name), f"'{name}' has no effect: no robot has a camera"
    mappings = [one for each in static.declared for one in each.function.mappings.values()]
    if static.is_complete and not any(isinstance(one, MapCSVRecorder) for one in mappings):
        yield ("csv_folder",), "'csv_folder' has no effect: no function has a CSV recorder"
