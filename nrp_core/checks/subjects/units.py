"""Neurons that are named twice, and values that are most likely in another unit."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians

from nrp_core.checks.examined import (
    ExaminedExperiment,
    checks_experiment,
)
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.scene.rigid import ROUNDED_TURN_RAD


@checks_experiment
def check_views(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report named populations with a repeated neuron."""
    if examined.network is None:
        return
    for name in examined.experiment.brain.populations:
        neurons = examined.network.views.get(name)
        if neurons is not None and len(set(neurons.tolist())) < len(neurons):
            message = f"the population '{name}' has {len(set(neurons.tolist()))} neurons, some of them twice"
            yield examined.warning(Code.NRP211, message, "brain", "populations", name)


@checks_experiment
def report_network(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report values in another unit, and parts of the script or file that the network lacks."""
    collector = Collector(examined.experiment.source)
    collector.place(examined.summary.findings, "brain", "model")
    yield from collector.findings


@checks_experiment
def check_poses(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report angles of poses given in degrees instead of radians."""
    experiment = examined.experiment
    owners: dict[tuple[Key, ...], str] = {}
    for name, robot in experiment.world.robots.items():
        owners["world", "robots", name] = f"'{name}'"
        for number, sensor in enumerate(robot.add_sensors):
            owners["world", "robots", name, "add_sensors", number] = f"the sensor on '{name}/{sensor.link}'"
    for place, owner in owners.items():
        for i, what in enumerate(("roll", "pitch", "yaw"), start=3):
            keys = (*place, "pose", i)
            written, reached = experiment.source.nearest(keys)
            value = written.value
            if reached == keys and isinstance(value, (int, float)) and abs(value) > ROUNDED_TURN_RAD:
                message = (
                    f"the {what} of {owner} is {value:g} rad, more than a turn; {value:g} degrees are "
                    f"{radians(value):.4g} rad"
                )
                yield written.place.finding(Code.NRP249, message, Level.WARNING)
