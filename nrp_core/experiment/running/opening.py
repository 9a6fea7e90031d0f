"""Open the engines of an experiment: both for a run, or the world alone."""

from __future__ import annotations

from typing import Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.brain.network.data import Network
from nrp_core.experiment.backends import named
from nrp_core.experiment.making.prepare import Side, prepare
from nrp_core.experiment.making.watch import declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import BackendSection, Experiment
from nrp_core.world.scene.model import Scene
from nrp_core.world.world import World


def open_side(section: BackendSection, side: Side[Any], content: Network | Scene, seed: int) -> Any:
    """Open the brain or the world of a section of an experiment."""
    with named(section.backend, "open"):
        return side.backend.open(content, seed=seed, options=side.options)


def open_beside(first: World, section: BackendSection, side: Side[Any], seed: int) -> World:
    """Open the scene of a world once more; the two share what never changes."""
    with named(section.backend, "open"):
        world: World = side.backend.open_another(first, seed=seed, options=side.options)
        return world


@checks_arguments()
def open_world(experiment: Experiment) -> World:
    """Open the world of an experiment without its brain, with the topics and aliases of the experiment.

    Events, criteria and transfer functions do not act; the caller steps the world.

    Raises:
        BackendError: a backend is missing, broken or does not open.
        InvalidExperimentError: the experiment is wrong; it carries all findings.
    """
    plan = prepare(experiment)
    world: World = open_side(experiment.world, plan.world, plan.scene, experiment.seed)
    collector = Collector(experiment.source)
    try:
        declare_own(experiment, world, collector)
        collector.raise_errors()
    except BaseException:
        world.close()
        raise
    return world
