"""What events, criteria and models need and the chosen world lacks."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.checks.examined import ExaminedExperiment, checks_experiment
from nrp_core.findings import Code, Finding
from nrp_core.findings.refusals import no_drive, world_lacks
from nrp_core.world.capabilities import needs_of


@checks_experiment
def check_distances(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report events and criteria about distances in a world that does not report poses of models."""
    if examined.world is None or examined.world.capabilities.poses:
        return
    experiment = examined.experiment
    near = [name for name, event in experiment.events.items() if event.when and event.when.near]
    criteria = [name for name, asked in experiment.criteria.items() if asked.near or asked.stays_within]
    events = (("events", name, "when", "near") for name in near)
    for keys in (*events, *(("criteria", name) for name in criteria)):
        message = f"'{keys[1]}' needs a distance: {world_lacks(experiment.world.backend, 'poses')}"
        yield experiment.place(*keys).finding(Code.NRP216, message)


@checks_experiment
def check_dynamics(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report models that cannot move, hold or be driven in the world as their files say."""
    if examined.world is None or examined.world.capabilities.own_scene:
        return
    has, backend = examined.world.capabilities, examined.experiment.world.backend
    for model in examined.models:
        held = [one.joint for one in model.controllers if one.initial is not None]
        lacking = [
            (j.name, need) for j in model.joints for need in needs_of(model, j) if not getattr(has, need)
        ]
        undriven = [(d.name, need) for d in model.drives for need in d.needs if not getattr(has, need)]
        message = ""
        if not (has.dynamics or model.static or model.drives):
            message = f"'{model.name}' could not move: {world_lacks(backend, 'dynamics')}"
        elif undriven:
            message = f"'{backend}' {no_drive(model.name, *undriven[0])}"
        elif held and not has.joint_control:
            message = f"'{model.name}' holds {held[0]}: {world_lacks(backend, 'joint_control')}"
        elif lacking and has.dynamics and not model.static:
            joint, need = lacking[0]
            message = f"'{model.name}/{joint}' could not move: {world_lacks(backend, need)}"
        if message:
            yield examined.experiment.place(*examined.keys_of(model.name)).finding(Code.NRP216, message)


@checks_experiment
def check_backend(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report models that the backend refuses for reasons of its own."""
    if examined.world is None or examined.scene is None:
        return
    for model, why in examined.world.backend.refusals(examined.scene):
        yield examined.experiment.place(*examined.keys_of(model)).finding(Code.NRP216, why)
