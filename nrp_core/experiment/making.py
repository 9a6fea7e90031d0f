"""How the parts of an experiment are made from what it names.

A reader of another format brings a :class:`Maker` of its own where a part is not simply a file in ours.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from nrp_core.brain.network import Network
from nrp_core.brain.script import load_network
from nrp_core.dsl.function import TransferFunction
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.findings import Code
from nrp_core.registry import plugins
from nrp_core.world.interface import World
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.scene.sdf import read_model, read_scene

if TYPE_CHECKING:
    from nrp_core.experiment.collector import Collector
    from nrp_core.experiment.model import Experiment
    from nrp_core.experiment.run import Run

LOADERS_GROUP = "nrp_core.transfer_functions"


class Maker:
    """Makes each part from the file that the experiment names; override what is made otherwise."""

    def room(self, experiment: Experiment) -> Scene:
        """Return the scene without robots.

        Raises:
            SceneError: it cannot be read.
        """
        return read_scene(experiment.world.scene, search_path=experiment.models)

    def robot(self, experiment: Experiment, name: str) -> Model:
        """Return a robot.

        Raises:
            SceneError: it cannot be read.
        """
        section = experiment.world.robots[name]
        return read_model(section.model, name=name, pose=section.start, search_path=experiment.models)

    def network(self, experiment: Experiment) -> Network:
        """Return the network of the brain.

        Raises:
            NetworkError: it cannot be made.
            NeuronSelectionError: a population reaches outside of it.
        """
        brain = experiment.brain
        return load_network(brain.model, populations=brain.populations, seed=experiment.seed)

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        """Yield new transfer functions; what is wrong with one goes to the collector."""
        loaders = plugins(LOADERS_GROUP, "loader of transfer functions")
        for i, path in enumerate(experiment.transfer_functions):
            with collector.during(Code.NRP210, "transfer_functions", i):
                if path.suffix not in loaders.names():
                    valid = did_you_mean(path.suffix, loaders.names())
                    raise ExperimentError(f"no transfer functions are read from '{path.name}'{valid}")
                yield from loaders.load(path.suffix)(path)

    def furnish(self, world: World, functions: Sequence[TransferFunction]) -> None:
        """Add to a world what these functions expect of it, such as further names of its topics."""

    def begin(self, run: Run) -> None:
        """Take part in a run that is about to begin, through the hooks of its loop."""
