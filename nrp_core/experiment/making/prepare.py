"""Make everything that an experiment needs but its engines, and find all that is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any, Generic, TypeVar

from nrp_core.brain.backends import brains
from nrp_core.brain.interface import BrainBackend
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.picking import blamed
from nrp_core.cle.wiring import declare_topics
from nrp_core.clock import StepPlan, seconds
from nrp_core.dsl.functions.collector import require_new_name
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.testing.mocks import MockBrain, MockWorld
from nrp_core.errors import NeuronSelectionError, did_you_mean
from nrp_core.experiment.backends import load_backend, named
from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.making.watch import Watch, declare_missing_topics, declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.event_schema import END, START
from nrp_core.experiment.model.experiment import BackendSection, Experiment
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Level, has_errors
from nrp_core.registry import Registry
from nrp_core.world.backends import worlds
from nrp_core.world.interface import WorldBackend
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.scene.sensing import Noise
from nrp_core.world.sensors.imperfect import with_imperfection
from nrp_core.world.world import World

ProgressCallback = Callable[[str], None]
"""Called with the name of each task as it begins."""

B = TypeVar("B", BrainBackend, WorldBackend)


def no_progress(task: str) -> None:
    """Report no progress."""


@dataclass(frozen=True, slots=True)
class Side(Generic[B]):
    """A backend as an experiment chooses it.

    Args:
        backend: the backend.
        options: an instance of its own model of options.
        capabilities: what it has under these.
    """

    backend: B
    options: Any
    capabilities: Any


@dataclass(frozen=True, slots=True)
class Plan:
    """An experiment that fits together: all it needs to open its engines.

    Args:
        experiment: what was asked for.
        brain, world: the two backends.
        network: for the brain.
        scene: for the world, robots included.
        functions: the transfer functions, not bound.
        warnings: what was found that does not keep it from running.
    """

    experiment: Experiment
    brain: Side[BrainBackend]
    world: Side[WorldBackend]
    network: Network
    scene: Scene
    functions: tuple[TransferFunction, ...]
    warnings: tuple[Finding, ...]


def prepare(experiment: Experiment, progress: ProgressCallback = no_progress) -> Plan:
    """Make everything that an experiment needs but its engines.

    Raises:
        BackendError: a backend is missing or broken.
        InvalidExperimentError: anything else is wrong; it carries all findings.
    """
    examined = Examination(experiment, progress)
    examined.collector.raise_errors()
    assert examined.brain is not None
    assert examined.world is not None
    assert examined.network is not None
    assert examined.scene is not None
    return Plan(
        experiment,
        examined.brain,
        examined.world,
        examined.network,
        examined.scene,
        examined.functions,
        tuple(examined.collector.findings),
    )


def side_of(
    collector: Collector, registry: Registry[B], side: str, section: BackendSection
) -> Side[B] | None:
    """Return a backend as an experiment chooses it; what is wrong goes to the collector."""
    with collector.during(Code.NRP205, side, "backend"):
        backend, options = load_backend(registry, side, section.backend, section.options, collector.source)
        with named(section.backend, "tell its capabilities"):
            return Side(backend, options, backend.capabilities(options))
    return None


def network_of(experiment: Experiment, collector: Collector) -> Network | None:
    """Return the network of an experiment; what is wrong with it goes to the collector."""
    with collector.during(Code.NRP208, "brain", "model"):
        try:
            return maker_of(experiment).network(experiment)
        except NeuronSelectionError as error:
            name = blamed(error, experiment.brain.populations)
            collector.add(Code.NRP211, error.message, "brain", "populations", name)
    return None


class Examination:
    """One look at an experiment; each part is None where it could not be made.

    Args:
        experiment: the experiment.
        progress: called with the name of each task as it begins.
    """

    def __init__(self, experiment: Experiment, progress: ProgressCallback) -> None:
        self._experiment = experiment
        self._lapse = Level.ERROR if experiment.strict else Level.WARNING
        self.collector = Collector(experiment.source)
        self.brain = side_of(self.collector, brains(), "brain", experiment.brain)
        self.world = side_of(self.collector, worlds(), "world", experiment.world)
        self._check_steps()
        self._check_event_names()
        progress("reading the room and the robots")
        self.scene = self._scene()
        progress("building the network")
        self.network = network_of(experiment, self.collector)
        self._fits = self._brain_fits()
        self.functions = tuple(maker_of(experiment).functions(experiment, self.collector))
        self._check_together()

    # -- the parts

    def _scene(self) -> Scene | None:
        scene, robots = None, self._experiment.world.robots
        with self.collector.during(Code.NRP209, "world", "scene"):
            scene = maker_of(self._experiment).room(self._experiment)
        models: list[Model] = []
        for name in robots:
            with self.collector.during(Code.NRP209, "world", "robots", name, level=self._lapse):
                models.append(maker_of(self._experiment).robot(self._experiment, name))
        if scene is None or (self._experiment.strict and len(models) < len(robots)):
            return None
        with self.collector.during(Code.NRP209, "world", "robots"):
            scene = reduce(Scene.with_model, models, scene)
            self.collector.findings += map(_warning, scene.warnings)
            return self._with_sensors(scene)
        return None

    def _with_sensors(self, scene: Scene) -> Scene:
        """Return the scene with sensors as bad as the experiment wants them."""
        for topic, section in self._experiment.world.sensors.items():
            with self.collector.during(Code.NRP209, "world", "sensors", topic):
                noise = None if section.noise is None else Noise(section.bias, section.noise)
                delay = None if section.delay is None else seconds(section.delay)
                scene = with_imperfection(scene, topic, noise=noise, delay=delay, drop_out=section.drop_out)
        return scene

    # -- how they fit together

    def _check_steps(self) -> None:
        brain_step_ns = self.brain.capabilities.resolution_ns if self.brain else None
        world_step_ns = self.world.capabilities.step_ns if self.world else None
        with self.collector.during(Code.NRP207, *self._step_written()):
            StepPlan(self._experiment.timestep, brain_step_ns, world_step_ns)

    def _step_written(self) -> tuple[Key, ...]:
        """Return the keys of a time step that is written for one side, else those of the loop's own."""
        for side in ("world", "brain"):
            keys = (side, "options", "timestep")
            if self._experiment.source.nearest(keys)[1] == keys:
                return keys
        return ("timestep",)

    def _check_event_names(self) -> None:
        events = self._experiment.events
        for keys, name in event_references(self._experiment):
            if name not in events:
                message = f"there is no event '{name}'{did_you_mean(name, events)}"
                self.collector.add(Code.NRP213, message, *keys)

    def _brain_fits(self) -> bool:
        """Whether the brain backend takes the network; collects what it would not keep of it."""
        if self.brain is None or self.network is None:
            return False
        name, before = self._experiment.brain.backend, len(self.collector.findings)
        with self.collector.during(Code.NRP216, "brain", "backend"):
            self.brain.capabilities.require(self.network, name)
            with self.collector.during(Code.NRP208, "brain", "model"), named(name, "look at the network"):
                for warning in self.brain.backend.warnings(self.network, self.brain.options):
                    self.collector.add(Code.NRP217, warning, "brain", "model", level=Level.WARNING)
        return not has_errors(self.collector.findings[before:])

    def _check_together(self) -> None:
        """Set everything up as for a run, with mocks, which check all that engines do."""
        if self.scene is None:
            return
        world = MockWorld(scene=self.scene)
        if declare_own(self._experiment, world, self.collector):
            Watch(self._experiment, world, self.collector)
            if self.network is not None:
                self._check_functions(self.network, world)

    def _check_functions(self, network: Network, world: World) -> None:
        with self.collector.during(Code.NRP216, "brain", "backend"):
            brain = MockBrain(
                network, capabilities=self.brain.capabilities if self.brain and self._fits else None
            )
            for topic in declare_missing_topics(self._experiment, world, self.functions):
                message = f"the world has no topic '{topic}': it is silent unless a function publishes on it"
                self.collector.add(Code.NRP212, message, "transfer_functions", level=Level.WARNING)
            declare_topics(self.functions, world)
            variables: dict[str, Any] = {}
            bound: list[TransferFunction] = []
            for function in self.functions:
                with self.collector.during(Code.NRP210, "transfer_functions", level=self._lapse):
                    require_new_name(function, bound)
                    bound.append(function.bind(brain, world, variables=variables))
            for function in bound:
                function.unbind()
            self.functions = tuple(bound)


def event_references(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], str]]:
    """Yield every place where an experiment names an event, with the name."""
    for name, event in experiment.events.items():
        if event.when is not None and event.when.event is not None:
            yield ("events", name, "when", "event"), event.when.event
    for name, criterion in experiment.criteria.items():
        if criterion.within_of is not None:
            yield ("criteria", name, "within_of", "event"), criterion.within_of.event
        for kind in ("stays_within", "topic_stays"):
            stays = getattr(criterion, kind)
            for key in ("since", "until") if stays is not None else ():
                moment = getattr(stays.during, key)
                if isinstance(moment, str) and moment not in (START, END):
                    yield ("criteria", name, kind, "during", key), moment


def _warning(text: str) -> Finding:
    """Turn a warning about a scene, which begins with its file and line, into a finding."""
    placed = re.match(r"(.+?):(\d+): ", text)
    if placed is None:
        return Finding(Code.NRP209, text, Level.WARNING)
    return Finding(Code.NRP209, text[placed.end() :], Level.WARNING, Path(placed[1]), int(placed[2]))
