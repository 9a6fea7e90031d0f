"""Make the parts of an experiment of NRP-core 4, and run its functions and engines in its runs."""

from __future__ import annotations

import ast
import threading
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from nrp_pynest.built import to_built_brain

from nrp_core.brain import Network
from nrp_core.dsl import Listing, TransferFunction
from nrp_core.experiment import (
    Build,
    Collector,
    Experiment,
    Maker,
    Participant,
    Platform,
    Run,
    RunObserver,
    Section,
    build_here,
)
from nrp_core.findings import Code, Finding, InvalidExperimentError
from nrp_core.parameters import Declared
from nrp_core.paths import ExistingFile
from nrp_core.world import Link, Model, Scene
from nrp_ebrains.config import GAZEBO, NEST, SINK, Configuration, EngineConfig, file_in, read_configuration
from nrp_ebrains.functions import Decorators, Function, load_function, require_engines, require_own_inputs
from nrp_ebrains.gazebo_engine import CAMERA, GazeboEngine, is_inert
from nrp_ebrains.graph import Node, NodeDecorators, load_nodes
from nrp_ebrains.loop import Engine, Loop
from nrp_ebrains.modules import module, scope_with
from nrp_ebrains.nest_engine import InitFile, NestEngine, NestObjects, build_network
from nrp_ebrains.python_engines import DataTransferEngine, PythonEngine

_LOCK = threading.RLock()
"""Held while the working directory is that of an experiment."""


class Options(Section):
    """The platform options of an experiment that ``nrp import`` wrote."""

    configuration: ExistingFile
    """The ``simulation_config.json`` with its engines and functions."""


class ConfigurationMaker(Maker, Participant[Run]):
    """Makes one experiment.

    Args:
        path: its configuration.
        configuration: the contents.
        notes: notes from reading it.

    Attributes:
        loop: the loop of the run that began last.
        stops_when_done: whether the run ends when the status function reports that it is done.
    """

    loop: Loop

    def __init__(self, path: Path, configuration: Configuration, notes: list[Finding]) -> None:
        self._path, self._configuration, self._notes = path, configuration, notes
        self._functions: list[Function] = []
        self._nodes: list[Node] = []
        self._scope = scope_with({}, {})
        self.stops_when_done = True

    @property
    def can_be_saved(self) -> bool:
        return False

    # -- parts

    def robot(self, experiment: Experiment, name: str) -> Model:
        """Return a model; cameras of several models from one file publish on topics of their own."""
        model = _without_false_warnings(super().robot(experiment, name))
        files = [str(one.model) for one in experiment.world.robots.values()]
        if files.count(str(experiment.world.robots[name].model)) == 1:
            return model
        return replace(model, links=tuple(_with_own_topics(link, name) for link in model.links))

    def room(self, experiment: Experiment) -> Scene:
        """Return the scene of the Gazebo engine, or an empty one."""
        return _without_false_warnings(super().room(experiment))

    def network(self, experiment: Experiment, build: Build = build_here) -> Network:
        files = [
            InitFile(
                one.EngineName, file_in(self._path.parent, one.NestInitFileName), one.EngineType == NEST[1]
            )
            for one in self._configuration.engines(*NEST)
        ]
        return build(partial(build_network, files, experiment.seed)) if files else Network({})

    def brain_parameters(self, experiment: Experiment) -> Declared:
        return Declared()

    def function_parameters(self, experiment: Experiment) -> Declared:
        return Declared()

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        """Load the functions, which the loop of NRP-core 4 runs and not that of this program."""
        collector.findings += self._notes
        names = [one.EngineName for one in self._configuration.EngineConfigs]
        decorators, of_nodes, shared = Decorators(), NodeDecorators(names), ModuleType("functions")
        graphs = {"nrp_core.event_loop": module("nrp_core.event_loop", of_nodes.names())}
        self._scope = scope_with(decorators.names(), graphs, self._path.parent)
        self._functions, self._nodes = [], []
        for path in self._functions_files():
            with collector.during(Code.NRP210), in_folder(self._path.parent):
                self._functions.append(load_function(path, self._scope, shared, decorators))
        for path in self._graph_files():
            with collector.during(Code.NRP210), in_folder(self._path.parent):
                self._nodes += load_nodes(path, self._scope, shared, of_nodes)
        with collector.during(Code.NRP210):
            require_engines([*self._functions, *self._nodes], names)
            require_own_inputs(self._functions)
        return iter(())

    def listings(self, experiment: Experiment, collector: Collector) -> Iterator[Listing]:
        """Report files that are not Python; their functions are not those of this program."""
        collector.findings += self._notes
        for path in (*self._functions_files(), *self._graph_files()):
            try:
                ast.parse(path.read_bytes())
            except SyntaxError as error:
                message = f"this is not Python: {error.msg}"
                collector.findings.append(Finding(Code.NRP210, message, path=path, line=error.lineno))
        return iter(())

    def _functions_files(self) -> list[Path]:
        return [file_in(self._path.parent, one.FileName) for one in self._configuration.functions]

    def _graph_files(self) -> list[Path]:
        return [file_in(self._path.parent, name) for name in self._configuration.graph]

    # -- the run

    def begin(self, run: Run) -> None:
        built = to_built_brain(run.brain.network)
        built.begin(run)
        engines = [self._engine(one, run, built) for one in self._configuration.EngineConfigs]
        step_ns, driven = self._configuration.graph_step_ns, self._configuration.EventLoop.is_driven
        self.loop = loop = Loop(engines, self._functions, self._scope, self._nodes, step_ns, is_driven=driven)
        folder = self._path.parent
        with in_folder(folder):
            loop.initialize()

        def iterate(_loop: object) -> None:
            with in_folder(folder):
                loop.iterate(run.loop.now_ns)
            if loop.done and self.stops_when_done:
                run.loop.stop()

        def reset(_loop: object) -> None:
            with in_folder(folder):
                loop.reset()

        run.loop.hooks.before_step.append(iterate)
        run.loop.hooks.after_reset.append(reset)
        run.observers.append(_Closing(lambda: self._shut_down(loop)))

    def _shut_down(self, loop: Loop) -> None:
        with in_folder(self._path.parent):
            loop.shutdown()

    def _engine(self, one: EngineConfig, run: Run, built: Any) -> Engine:
        name, step_ns, folder = one.EngineName, one.step_ns, self._path.parent
        if one.EngineType in NEST:
            assert isinstance(built, NestObjects)
            return NestEngine(name, step_ns, built)
        if one.EngineType in GAZEBO:
            in_json = one.EngineType == GAZEBO[1]
            return GazeboEngine(name, step_ns, run.world, in_json=in_json, warn=run.world.warnings.add)
        if one.EngineType == SINK:
            names = [dump.name for dump in one.dumps if dump.file]
            return DataTransferEngine(name, step_ns, folder / one.dataDirectory, names)
        return PythonEngine(
            name, step_ns, file_in(folder, one.PythonFileName), one.model_dump(exclude_none=True)
        )


Warned = TypeVar("Warned", Model, Scene)


def _without_false_warnings(read: Warned) -> Warned:
    """Return what was read without warnings of plugins that give parts a datapack: all have one here."""
    warnings = (one for one in read.warnings if not (one.code is Code.NRP260 and is_inert(one.subject or "")))
    return replace(read, warnings=tuple(warnings))


def _with_own_topics(link: Link, model: str) -> Link:
    """Return a link whose cameras publish below the name of the model."""

    def own(camera: Any) -> Any:
        topics: dict[str, Any] = {
            name: f"/{model}{topic}"
            for name in ("topic", "info_topic", "depth_topic", "points_topic")
            if (topic := getattr(camera, name)) is not None
        }
        return replace(camera, **topics)

    sensors = (own(one) if one.tag == CAMERA else one for one in link.sensors)
    return replace(link, sensors=tuple(sensors))


class _Closing(RunObserver[Run]):
    """Ends the engines with the run."""

    def __init__(self, close: Callable[[], None]) -> None:
        self._close = close

    def closing(self, run: Run) -> None:
        self._close()


@contextmanager
def in_folder(folder: Path) -> Iterator[None]:
    """Make a folder the working directory, in which files of the experiment open others."""
    with _LOCK, chdir(folder):
        yield


def maker_for(experiment: Experiment, options: Options) -> ConfigurationMaker:
    """Return the maker of an experiment that ``nrp import`` wrote.

    Raises:
        InvalidExperimentError: its configuration is not valid.
    """
    path = Path(options.configuration)
    configuration, _, notes = read_configuration(path)
    if configuration.timestep_ns != experiment.timestep:
        place = experiment.place("timestep")
        message = f"the engines of {path.name} need a time step of {configuration.timestep_ns / 1e6:g} ms"
        raise InvalidExperimentError([place.finding(Code.NRP372, message)])
    return ConfigurationMaker(path, configuration, notes)


PLATFORM = Platform(Options, maker_for)
"""``nrp_core_4``."""
