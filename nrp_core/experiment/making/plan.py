"""An experiment whose parts are made, and that opens its engines from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from nrp_core.brain.backend import BrainBackend
from nrp_core.dsl.functions import TransferFunction
from nrp_core.experiment.making.maker import Parameters, maker_of
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Finding
from nrp_core.network.data import Network
from nrp_core.scene.model import Scene
from nrp_core.world.backend import WorldBackend
from nrp_core.world.world import World

ProgressCallback = Callable[[str], None]
"""Called with the name of each task as it begins."""

B = TypeVar("B", BrainBackend, WorldBackend)


def no_progress(task: str) -> None:
    """Report no progress."""


@dataclass(frozen=True, slots=True)
class Side(Generic[B]):
    """A backend as selected by an experiment.

    Args:
        backend: the backend.
        options: an instance of its class of options.
        capabilities: its capabilities with these options.
    """

    backend: B
    options: Any
    capabilities: Any


@dataclass(frozen=True, slots=True)
class PlanParts:
    """The parts of an experiment, as far as they could be made; a part that could not be made is None.

    Args:
        experiment: the experiment, without the values of parameters that do not fit.
        brain, world: the two backends.
        network: the network of the brain.
        scene: the scene of the world, robots included.
        stage: a world without an engine, with the topics and aliases of the experiment.
        parameters: those of the brain script and the transfer functions, with their values.
        is_accepted: whether the brain backend accepts the network.
        collector: the findings.
    """

    experiment: Experiment
    brain: Side[BrainBackend] | None
    world: Side[WorldBackend] | None
    network: Network | None
    scene: Scene | None
    stage: World | None
    parameters: Parameters
    is_accepted: bool
    collector: Collector


@dataclass(frozen=True, slots=True)
class Plan:
    """A consistent experiment: everything it needs to open its engines.

    Args:
        experiment: the experiment.
        brain, world: the two backends.
        network: the network of the brain.
        scene: the scene of the world, robots included.
        stage: a world without an engine, with the topics of the run.
        functions: the transfer functions, not yet bound.
        parameters: those of the brain script and the transfer functions, with their values.
        warnings: findings that do not prevent a run.
    """

    experiment: Experiment
    brain: Side[BrainBackend]
    world: Side[WorldBackend]
    network: Network
    scene: Scene
    stage: World
    functions: tuple[TransferFunction, ...]
    parameters: Parameters
    warnings: tuple[Finding, ...]

    def with_fresh_functions(self) -> Plan:
        """Return the plan of one more run, with functions of its own: files may keep values between calls.

        Network and scene, which never change, are shared, and so are the values of parameters.

        Raises:
            InvalidExperimentError: a file of transfer functions has changed since, and is wrong.
        """
        collector = Collector(self.experiment.source)
        experiment = self.parameters.given_to(self.experiment)
        functions = tuple(maker_of(experiment).functions(experiment, collector))
        collector.raise_errors()
        names = {function.name for function in self.functions}  # others were omitted, with a finding
        return replace(self, functions=tuple(each for each in functions if each.name in names))
