"""An experiment on engines without a simulator, the command line, and worlds to compare."""

from collections.abc import Callable
from pathlib import Path

import pytest
from command_fixtures import experiment, nrp, nrp_process
from experiment_fixtures import _place, drive_to_the_wall, fakes, install, raising, site

__all__ = [
    "_place",
    "drive_to_the_wall",
    "experiment",
    "fakes",
    "install",
    "nrp",
    "nrp_process",
    "raising",
    "site",
]

FAST = """
from dataclasses import replace

from experiment_fakes import DiscBackend, DiscEngine
from nrp_lab.comparison.metric import ScalarMetric


class FastEngine(DiscEngine):
    def _do_set_drive(self, model, drive, velocity):
        super()._do_set_drive(model, drive, replace(velocity, forward=1.5 * velocity.forward))


class FastBackend(DiscBackend):
    def engine(self, scene, *, seed, options):
        return FastEngine(scene, self.capabilities(options), seed=seed, identity="fast")


class TwinBackend(DiscBackend):
    pass


class Steps(ScalarMetric):
    name, title = "steps", "Steps"

    def values(self, run):
        return {"all": float(run.result["steps"])}
"""
ENTRIES = (
    "[nrp_core.world]\nfast = fast:FastBackend\ntwin = fast:TwinBackend\n"
    "[nrp_core.metrics]\nsteps = fast:Steps\n"
)


@pytest.fixture
def worlds(experiment: Path, install: Callable[..., None]) -> Path:
    """The experiment, a world like its own, one that drives faster, and a metric of somebody else."""
    install("fast", ENTRIES, FAST)
    return experiment
