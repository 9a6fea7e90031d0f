"""The world of an experiment, without its brain."""

from __future__ import annotations

from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.making.watch import declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.world.world import World


def open_world(experiment: Experiment) -> World:
    """Open the world of an experiment, with its topics and aliases.

    Raises:
        BackendError: a backend is missing, broken or does not open.
        InvalidExperimentError: the experiment is wrong.
    """
    plan = prepare(experiment)
    world = plan.world.backend.open(plan.scene, seed=experiment.seed, options=plan.world.options)
    collector = Collector(experiment.source)
    declare_own(experiment, world, collector)
    collector.raise_errors()
    return world
