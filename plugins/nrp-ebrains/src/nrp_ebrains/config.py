"""The file of an experiment of NRP-core 4, ``simulation_config.json``, and its supported parts."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import reduce
from math import gcd
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, Field, field_validator

from nrp_core.clock import from_seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Key, Place, Tree, form_of, parse_tree
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level

WHAT: Final = "a configuration of NRP-core 4"
_MARKS: Final = ('"EngineConfigs"', '"ComputationalGraph"')
"""Every configuration contains one of these; other JSON files do not."""
PYTHON: Final = ("python_json", "python_grpc", "py_sim")
GAZEBO: Final = ("gazebo_grpc", "gazebo_json")
NEST: Final = ("nest_json", "nest_server")
SINK: Final = "datatransfer_grpc_engine"
_TYPES: Final = (*PYTHON, *GAZEBO, *NEST, SINK)
_ELSEWHERE: Final = {
    "edlut_grpc_engine": "the simulator EDLUT", "unity_grpc_engine": "Unity",
    "opensim_json": "OpenSim", "opensim_grpc": "OpenSim", "tvb": "The Virtual Brain",
}  # fmt: skip
"""Engines of NRP-core 4 for which there is no counterpart."""
_FILES: Final = {
    **dict.fromkeys(PYTHON, "PythonFileName"), **dict.fromkeys(GAZEBO, "GazeboWorldFile"),
    **dict.fromkeys(NEST, "NestInitFileName"),
}  # fmt: skip
EVENT_LOOP: Final = "EventLoop"
"""The loop that follows the clock in NRP-core 4."""
_SIMULATORS: Final = ("Mujoco", "Bullet", "OpenAI", "Opensim")
_PROGRAMS: Final = {
    "async_python_json_engine.py": PYTHON[0], "async_python_grpc_engine.py": PYTHON[1],
    "async_pysim_engine.py": PYTHON[2], "gzserver": GAZEBO[0],
}  # fmt: skip
"""Programs that run an engine beside an event loop, with the type of the engine."""


class _Form(BaseModel):
    model_config = ConfigDict(extra="allow")


class ModelConfig(_Form):
    """A model that a Gazebo engine adds to its world."""

    Name: str = Field(min_length=1)
    File: str
    InitPose: str = "0 0 0 0 0 0"

    @field_validator("InitPose")
    @classmethod
    def _six(cls, text: str) -> str:
        if len([float(one) for one in text.split()]) != 6:
            raise ValueError("InitPose is 'x y z roll pitch yaw', six numbers")
        return text

    @property
    def pose(self) -> list[float]:
        """Position (m) and roll, pitch, yaw (rad)."""
        return [float(one) for one in self.InitPose.split()]


class DumpConfig(_Form):
    """A datapack that a sink writes or sends."""

    name: str
    network: bool = False
    file: bool = False


class EngineConfig(_Form):
    """One engine; keys of other engines and those of transport are not read."""

    EngineName: str = Field(min_length=1)
    EngineType: str
    EngineTimestep: float = Field(default=0.01, gt=0)
    EngineExtraConfigs: dict[str, Any] = Field(default_factory=dict)
    PythonFileName: str | None = None
    NestInitFileName: str | None = None
    GazeboWorldFile: str | None = None
    GazeboSDFModels: list[ModelConfig] = Field(default_factory=list)
    GazeboRNGSeed: int = 0
    Simulator: str | None = None
    WorldFileName: str | None = None
    Visualizer: bool = False
    dataDirectory: str = "data"
    dumps: list[DumpConfig] = Field(default_factory=list)

    @property
    def step_ns(self) -> int:
        """Its time step."""
        return from_seconds(self.EngineTimestep)

    @property
    def file(self) -> str | None:
        """The main file of the engine."""
        return getattr(self, _FILES[self.EngineType]) if self.EngineType in _FILES else None


class FunctionConfig(_Form):
    """A file with one function."""

    Name: str
    FileName: str
    IsActive: bool = True


class EventLoopConfig(_Form):
    """How often an event loop runs its graph, and for how long: s."""

    Timestep: float = Field(default=0.01, gt=0)
    Timeout: float = Field(default=0.0, ge=0)
    ExecutionMode: str = "AllNodes"

    @property
    def is_driven(self) -> bool:
        """Whether only the nodes that outputs need are run."""
        return self.ExecutionMode == "OutputDriven"


class _ProcessConfig(_Form):
    """A program that is started beside the loop."""

    ProcCmd: str = ""
    ProcStartParams: list[str] = Field(default_factory=list)


class Configuration(_Form):
    """The whole file; it may have further keys."""

    SimulationName: str = ""
    SimulationDescription: str = ""
    SimulationTimeout: float = Field(default=0.0, ge=0)
    SimulationLoop: str = "FTILoop"
    DataPackProcessor: str = "tf"
    EngineConfigs: list[EngineConfig] = Field(default_factory=list)
    DataPackProcessingFunctions: list[FunctionConfig] = Field(default_factory=list)
    StatusFunction: FunctionConfig | None = None
    ComputationalGraph: list[str] = Field(default_factory=list)
    EventLoop: EventLoopConfig = Field(default_factory=EventLoopConfig)

    @property
    def timestep_ns(self) -> int:
        """The longest step of which every engine's step, and that of an event loop, is a multiple."""
        return reduce(gcd, (engine.step_ns for engine in self.EngineConfigs), self.graph_step_ns or 0)

    @property
    def timeout_s(self) -> float:
        """The duration of the run; 0 without one."""
        return self.SimulationTimeout or (self.EventLoop.Timeout if self.graph_step_ns else 0.0)

    @property
    def graph_step_ns(self) -> int | None:
        """The step of an event loop; None in a loop whose graph runs with its engines."""
        return from_seconds(self.EventLoop.Timestep) if self.SimulationLoop == EVENT_LOOP else None

    def engines(self, *types: str) -> list[EngineConfig]:
        """Return the engines of some types."""
        return [engine for engine in self.EngineConfigs if engine.EngineType in types]

    @property
    def functions(self) -> list[FunctionConfig]:
        """The functions that are active, the status function last."""
        status = [self.StatusFunction] if self.StatusFunction else []
        functions = self.DataPackProcessingFunctions if not self._has_graph else []
        return [one for one in (*functions, *status) if one.IsActive]

    @property
    def graph(self) -> list[str]:
        """The files of the computational graph, which takes the place of functions."""
        return self.ComputationalGraph if self._has_graph else []

    @property
    def _has_graph(self) -> bool:
        return self.DataPackProcessor == "cg" or self.SimulationLoop == EVENT_LOOP


def is_configuration(path: Path) -> bool:
    """Return whether a JSON file is a configuration."""
    try:
        text = path.read_text("utf-8-sig")
        return any(mark in text for mark in _MARKS)
    except (OSError, UnicodeDecodeError):
        return False


def read_configuration(path: Path) -> tuple[Configuration, Tree, list[Finding]]:
    """Read a configuration.

    Returns:
        it, its values with their places, and notes about what is ignored.

    Raises:
        InvalidExperimentError: it is not valid, or needs something that is not supported.
    """
    tree = _tree(path)
    notes = _take_processes(tree, path.parent)
    configuration = form_of(tree, Configuration, WHAT)
    found = [*_unsupported(configuration, tree), *_missing(configuration, tree)]
    if found:
        raise InvalidExperimentError(found)
    return configuration, tree, [*notes, *_ignored(configuration, tree)]


def _take_processes(tree: Tree, folder: Path) -> list[Finding]:
    """Add the engines that are programs beside an event loop; return notes about the other programs.

    Raises:
        InvalidExperimentError: the file of such an engine does not exist or is not valid.
    """
    found, loop, processes = [], tree.at("SimulationLoop"), tree.at("ExternalProcesses")
    for one in processes.value if processes and isinstance(processes.value, list) else ():
        process = form_of(one, _ProcessConfig, "a program")
        kind = _PROGRAMS.get(Path(process.ProcCmd).name) if loop and loop.value == EVENT_LOOP else None
        names = [text[9:] for text in process.ProcStartParams if text.startswith("--config=")]
        if kind is None or not names:
            message = f"'{process.ProcCmd}' is not started: everything runs in this process"
            found.append(one.place.finding(Code.NRP216, message, Level.WARNING))
            continue
        if not (folder / names[0]).is_file():
            raise InvalidExperimentError([one.place.finding(Code.NRP204, f"there is no file '{names[0]}'")])
        own = _tree(folder / names[0])
        engine = own.at("EngineConfig") or Tree({}, own.place)
        engine.value["EngineType"] = Tree(kind, one.place)
        if (step := own.at("Timestep")) is not None:
            engine.value["EngineTimestep"] = step
        if kind in GAZEBO:  # the world is the last argument of gzserver
            engine.value["GazeboWorldFile"] = Tree(process.ProcStartParams[-1], one.place)
        tree.value.setdefault("EngineConfigs", Tree([], one.place)).value.append(engine)
    return found


def _tree(path: Path) -> Tree:
    try:
        text = path.read_text("utf-8-sig")
        content = json.loads(text)
        if not isinstance(content, dict):
            raise ExperimentError(f"{WHAT} is an object: {{...}}", path=path, line=1)
        try:
            return parse_tree(text.replace("\t", " "), Place(path))  # JSON is YAML, but for tabs
        except ExperimentError:  # and for a key that is given twice, whose last value counts
            return parse_tree(json.dumps(content), Place(path))
    except json.JSONDecodeError as error:
        message = f"not JSON: {error.msg}"
        wrong = ExperimentError(message, path=path, line=error.lineno, column=error.colno)
        raise InvalidExperimentError([Finding.of(wrong, Code.NRP200)]) from None
    except UnicodeDecodeError:
        wrong = ExperimentError("the file is not UTF-8", path=path)
        raise InvalidExperimentError([Finding.of(wrong, Code.NRP200)]) from None
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from None


def _unsupported(configuration: Configuration, tree: Tree) -> Iterator[Finding]:
    """Yield an error for each feature without a counterpart here."""

    def no(message: str, *keys: Key, code: Code = Code.NRP216) -> Finding:
        return tree.place_of(*keys).finding(code, message)

    loop, processor = configuration.SimulationLoop, configuration.DataPackProcessor
    if loop not in ("FTILoop", EVENT_LOOP):
        yield no(f"SimulationLoop must be FTILoop or {EVENT_LOOP}, not '{loop}'", "SimulationLoop")
    elif processor not in ("tf", "cg"):
        message = f"there is no DataPackProcessor '{processor}'; valid: tf, cg"
        yield no(message, "DataPackProcessor")
    if not configuration.EngineConfigs and not configuration.graph_step_ns:
        yield no("there is no engine: EngineConfigs is empty", "EngineConfigs")
    for i in range(len(configuration.EngineConfigs)):
        yield from _unsupported_engine(configuration, i, no)
    names = [one.Name for one in configuration.DataPackProcessingFunctions if one.IsActive]
    for i, name in enumerate(names):
        if name in names[:i]:
            keys = "DataPackProcessingFunctions", i, "Name"
            yield no(f"two functions have the name '{name}'", *keys, code=Code.NRP202)
    if len(configuration.engines(*GAZEBO)) > 1:
        yield no("two Gazebo engines in one experiment are not supported", "EngineConfigs")


def _unsupported_engine(
    configuration: Configuration, i: int, no: Callable[..., Finding]
) -> Iterator[Finding]:
    engines = configuration.EngineConfigs
    engine, keys = engines[i], ("EngineConfigs", i)
    kind = engine.EngineType
    if engine.EngineName in (one.EngineName for one in engines[:i]):
        yield no(f"two engines have the name '{engine.EngineName}'", *keys, "EngineName", code=Code.NRP202)
    if kind.lower() in _ELSEWHERE:
        yield no(f"{_ELSEWHERE[kind.lower()]} ('{kind}') is not supported", *keys, "EngineType")
    elif kind not in _TYPES:
        yield no(f"there is no EngineType '{kind}'{did_you_mean(kind, _TYPES)}", *keys, "EngineType")
    if engine.Simulator is not None and engine.Simulator not in _SIMULATORS:
        valid = ", ".join(_SIMULATORS)
        yield no(f"the simulator '{engine.Simulator}' is not supported; valid: {valid}", *keys, "Simulator")


def _missing(configuration: Configuration, tree: Tree) -> Iterator[Finding]:
    """Yield an error for each file that is not named or does not exist."""
    for i, engine in enumerate(configuration.EngineConfigs):
        if engine.EngineType in _FILES:
            key = _FILES[engine.EngineType]
            yield from _missing_file(engine.file, tree, key, "EngineConfigs", i)
        for j, model in enumerate(engine.GazeboSDFModels):
            yield from _missing_file(model.File, tree, "File", "EngineConfigs", i, "GazeboSDFModels", j)
    for i, function in enumerate(configuration.DataPackProcessingFunctions):
        if function.IsActive:
            keys = "DataPackProcessingFunctions", i
            yield from _missing_file(function.FileName, tree, "FileName", *keys)
    for i, name in enumerate(configuration.ComputationalGraph):
        yield from _missing_file(name, tree, i, "ComputationalGraph")
    if configuration.StatusFunction:
        yield from _missing_file(configuration.StatusFunction.FileName, tree, "FileName", "StatusFunction")


def _missing_file(name: str | None, tree: Tree, key: Key, *above: Key) -> Iterator[Finding]:
    if name is None:
        yield tree.place_of(*above).finding(Code.NRP201, f"'{key}' is missing")
        return
    place = tree.place_of(*above, key)
    if not file_in(place.folder, name).is_file():
        yield place.finding(Code.NRP204, f"there is no file '{name}'")


def file_in(folder: Path, name: str | None) -> Path:
    """Return a file of an experiment; one with a path inside a container is beside the configuration."""
    path = folder / str(name)
    beside = folder / path.name
    return beside if not path.is_file() and beside.is_file() else path


def _ignored(configuration: Configuration, tree: Tree) -> Iterator[Finding]:
    """Yield a note for each kind of feature that has no effect here."""

    def note(message: str, *keys: Key) -> Finding:
        return tree.place_of(*keys).finding(Code.NRP216, message, Level.WARNING)

    extra = configuration.model_extra or {}
    for key in ("ROSNode", "MQTTNode"):
        if key in extra:
            yield note(f"'{key}' is ignored: everything runs in this process", key)
    for i, engine in enumerate(configuration.EngineConfigs):
        if any(dump.network and not dump.file for dump in engine.dumps):
            yield note(
                "datapacks for the network are not sent: there is no MQTT here", "EngineConfigs", i, "dumps"
            )
            break
    if configuration.graph_step_ns:
        yield note(
            "the EventLoop runs in lockstep with simulated time here, not with the clock: its graph every "
            f"{configuration.EventLoop.Timestep:g} s, and each engine at its own time step",
            "SimulationLoop",
        )
    if not configuration.timeout_s:
        yield note("there is no SimulationTimeout: the run takes 10 s; -s duration=... sets another",
                   "SimulationTimeout")  # fmt: skip
