"""Make the parts of an experiment from its file.

A reader of another format has its own :class:`Maker` if a part is not simply a file in our format.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from nrp_core.brain.network.data import Network
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.loading import Listing
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.making.networks import network_from
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Build, Experiment, PartMaker
from nrp_core.findings import Code, Level
from nrp_core.parameters import FUNCTIONS, read_parameters
from nrp_core.registry import Registry
from nrp_core.world.robot_setup import set_up_robot
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.scene.reading.context import read_without
from nrp_core.world.scene.sdf import read_model, read_scene

Loader: TypeAlias = Callable[..., list[TransferFunction]]
Lister: TypeAlias = Callable[[Path], Listing]

LOADERS: Registry[Loader] = Registry("nrp_core.transfer_functions", "loader of transfer functions")
LISTERS: Registry[Lister] = Registry("nrp_core.transfer_function_listings", "reader of transfer functions")


def build_here(make: Callable[[], Network]) -> Network:
    """Make a network in this process."""
    return make()


class Maker(PartMaker):
    """Makes each part from the file that the experiment names; subclasses replace methods for others."""

    def room(self, experiment: Experiment) -> Scene:
        """Return the scene without robots, empty without a file; if not strict, without what cannot be used.

        Raises:
            SceneError: it cannot be read.
        """
        path, models = experiment.world.scene, experiment.models
        if path is None:
            return Scene(())
        if experiment.strict:
            return read_scene(path, search_path=models)
        read = partial(read_scene, path, search_path=models, lenient=True)
        scene, left_out = read_without(lambda without: read(without=without))
        return replace(scene, warnings=(*scene.warnings, *left_out))

    def robot(self, experiment: Experiment, name: str) -> Model:
        """Return a robot; if the experiment is not strict, without what cannot be used.

        Raises:
            SceneError: it cannot be read.
        """
        section, models = experiment.world.robots[name], experiment.models
        read = partial(
            read_model, section.model, name=name, pose=section.start, search_path=models, args=section.args
        )
        if experiment.strict:
            return self._fitted(experiment, name, read())
        model, left_out = read_without(lambda without: read(without=without))
        return self._fitted(experiment, name, replace(model, warnings=(*model.warnings, *left_out)))

    def _fitted(self, experiment: Experiment, name: str, model: Model) -> Model:
        """Return a robot with what the experiment adds to it; findings about that stand in the experiment."""
        result = set_up_robot(model, experiment.world.robots[name].fitting)
        place = experiment.place("world", "robots", name)
        warnings = [
            one if one.path else replace(place.finding(one.code, one.message, one.level), subject=one.subject)
            for one in result.warnings
        ]
        return replace(result, warnings=tuple(warnings))

    def network(self, experiment: Experiment, build: Build = build_here) -> Network:
        brain = experiment.brain
        return build(
            partial(
                network_from, brain.model, populations=brain.populations, seed=experiment.seed,
                parameters=brain.parameters,
            )
        )  # fmt: skip

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        for i, path in enumerate(experiment.transfer_functions):
            with collector.during(Code.NRP210, "transfer_functions", i):
                yield from load_function_file(path, experiment.function_parameters)

    def listings(self, experiment: Experiment, collector: Collector) -> Iterator[Listing]:
        for i, path in enumerate(experiment.transfer_functions):
            with collector.during(Code.NRP210, "transfer_functions", i):
                if _suffix(path) in LISTERS.names():
                    yield LISTERS.load(path.suffix)(path)
                else:
                    message = f"'{path.name}' is known only when it runs"
                    collector.add(Code.NRP239, message, "transfer_functions", i, level=Level.NOTE)


def maker_of(experiment: Experiment) -> PartMaker:
    """Return the maker of an experiment: its own, or the one for our formats."""
    return experiment.maker or Maker()


def load_function_file(
    path: Path, parameters: Mapping[str, object] = MappingProxyType({})
) -> list[TransferFunction]:
    """Return the transfer functions of a file of any supported kind.

    Args:
        path: the file.
        parameters: values of parameters; a loader gets those that its file declares.

    Raises:
        ExperimentError: the kind is not supported, or the file is invalid.
    """
    loader = LOADERS.load(_suffix(path))
    declared = read_parameters(path, FUNCTIONS).parameters if parameters else ()
    given = {name: parameters[name] for name in declared if name in parameters}
    return loader(path, parameters=given) if given else loader(path)


def _suffix(path: Path) -> str:
    """Return the registered suffix of a file."""
    if path.suffix not in LOADERS.names():
        valid = did_you_mean(path.suffix, LOADERS.names())
        raise ExperimentError(f"no transfer functions are read from '{path.name}'{valid}")
    return path.suffix
