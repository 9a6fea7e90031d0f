"""Engines that are Python scripts, and the sink of datapacks.

A script has a class ``Script``. Each engine executes its file in a scope of its own, as NRP-core 4 gives each
a process of its own: modules and global variables are never shared.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

from google.protobuf.message import Message

from nrp_core.clock import NS_PER_S
from nrp_core.errors import ExperimentError, SimulationError, did_you_mean
from nrp_ebrains.datapacks import DataPack, JsonData, copied, plain
from nrp_ebrains.loop import Engine
from nrp_ebrains.messages import as_lines
from nrp_ebrains.modules import module, scope_with
from nrp_ebrains.simulators import Simulator, open_simulator


class EngineScript:
    """The base class of scripts with JSON datapacks; a script overrides the four methods below."""

    _kind = "a dictionary"

    def __init__(self) -> None:
        self._datapacks: dict[str, Any] = {}
        self._time_ns = 0
        self._name = ""
        self._config: dict[str, Any] = {}

    # ruff: noqa: N802 - the names of NRP-core 4

    def initialize(self) -> None:
        """Get ready."""

    def runLoop(self, timestep_ns: int) -> None:
        """Take one step; ``_time_ns`` is already the time at its end."""

    def shutdown(self) -> None:
        """End."""

    def reset(self) -> None:
        """Return to the start."""

    def _getEngineName(self) -> str:
        return self._name

    def _registerDataPack(self, datapack_name: str) -> None:
        if datapack_name in self._datapacks:
            raise ExperimentError(f"the datapack '{datapack_name}' is already registered")
        self._datapacks[datapack_name] = None

    def _getRegisteredDataPackNames(self) -> list[str]:
        return list(self._datapacks)

    def _getDataPack(self, datapack_name: str) -> Any:
        self._require(datapack_name)
        return self._datapacks[datapack_name]

    def _setDataPack(self, datapack_name: str, data: Any) -> None:
        self._require(datapack_name)
        self._datapacks[datapack_name] = data

    def _require(self, name: str) -> None:
        if name not in self._datapacks:
            raise ExperimentError(
                f"the datapack '{name}' is not registered{did_you_mean(name, self._datapacks)}"
            )

    def _take(self, name: str, content: Any) -> None:
        """Take a datapack from a function."""
        if isinstance(content, Message):
            raise ExperimentError(f"the datapack '{name}' must be JSON, not {content.DESCRIPTOR.full_name}")
        self._setDataPack(name, plain(content))

    def _shown(self, name: str) -> Any:
        """Return a datapack for functions."""
        return JsonData(plain(self._getDataPack(name)))


class GrpcEngineScript(EngineScript):
    """The base class of scripts with messages of Protocol Buffers."""

    def __init__(self) -> None:
        super().__init__()
        self._types: dict[str, type[Message]] = {}

    def _registerDataPack(self, datapack_name: str, datapack_type: type[Message]) -> None:  # type: ignore[override]
        super()._registerDataPack(datapack_name)
        self._types[datapack_name] = datapack_type
        self._datapacks[datapack_name] = datapack_type()

    def _setDataPack(self, datapack_name: str, data: Any) -> None:
        self._require(datapack_name)
        expected = self._types[datapack_name].DESCRIPTOR.full_name
        if not isinstance(data, Message) or data.DESCRIPTOR.full_name != expected:
            raise TypeError(
                f"the datapack '{datapack_name}' is a message {expected}, not {type(data).__name__}"
            )
        self._datapacks[datapack_name] = data

    def _take(self, name: str, content: Any) -> None:
        self._setDataPack(name, copied(content) if isinstance(content, Message) else content)

    def _shown(self, name: str) -> Any:
        return copied(self._getDataPack(name))


class _WithSimulator(EngineScript):
    """Opens the simulator of the engine when a script first uses it."""

    _folder = Path()
    _simulator: Simulator | None = None

    @property
    def sim_manager(self) -> Simulator:
        """The simulator of this engine."""
        if self._simulator is None:
            self._simulator = open_simulator(self._config, self._folder)
        return self._simulator


class PySimEngineScript(_WithSimulator):
    """A script with a simulator and JSON datapacks."""


class PySimGrpcEngineScript(GrpcEngineScript, _WithSimulator):
    """A script with a simulator and messages."""


_ENGINE_MODULES: dict[str, dict[str, Any]] = {
    "nrp_core.engines.python_json": {"EngineScript": EngineScript, "RegisterEngine": lambda: lambda cls: cls},
    "nrp_core.engines.python_grpc": {"GrpcEngineScript": GrpcEngineScript},
    "nrp_core.engines.py_sim": {
        "PySimEngineScript": PySimEngineScript, "PySimGrpcEngineScript": PySimGrpcEngineScript,
    },
}  # fmt: skip


class PythonEngine(Engine):
    """An engine whose file defines a class ``Script``.

    Args:
        name: its name.
        step_ns: its time step.
        path: its file.
        config: its settings in the configuration.
    """

    def __init__(self, name: str, step_ns: int, path: Path, config: Mapping[str, Any]) -> None:
        super().__init__(name, step_ns)
        self._path, self._config = path, dict(config)
        modules = {dotted: module(dotted, names) for dotted, names in _ENGINE_MODULES.items()}
        self._scope = scope_with({}, modules, path.parent)
        self._script = EngineScript()

    def initialize(self) -> None:
        self._guarded(self._load)

    def _load(self) -> None:
        found = getattr(self._scope.run(self._path), "Script", None)
        if not (isinstance(found, type) and issubclass(found, EngineScript)):
            raise ExperimentError(
                f"the file of the engine '{self.name}' must define a class Script that extends EngineScript",
                path=self._path,
            )
        self._script = script = found()
        script._name, script._config = self.name, self._config
        if isinstance(script, _WithSimulator):
            script._folder = self._path.parent
        script.initialize()

    def read(self, names: Iterable[str]) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self._guarded(lambda: {name: self._script._shown(name) for name in names})
        return found

    def write(self, packs: Sequence[DataPack]) -> None:
        def take() -> None:
            for pack in packs:
                self._script._take(pack.name, pack.data)

        self._guarded(take)

    def start_step(self) -> None:
        self._script._time_ns += self.step_ns
        self._guarded(lambda: self._script.runLoop(self.step_ns))

    def reset(self) -> None:
        self._guarded(self._script.reset)
        self._script._time_ns = 0

    def shutdown(self) -> None:
        self._guarded(self._script.shutdown)
        simulator = getattr(self._script, "_simulator", None)
        if simulator is not None:
            simulator.shutdown()

    def _guarded(self, call: Any) -> Any:
        """Make a call into the script; its exceptions name the engine, the file and the line."""
        try:
            return call()
        except (Exception, SystemExit) as error:
            located = self._scope.located(error, ExperimentError, self._path)
            raise SimulationError(f"the engine '{self.name}' failed: {located}") from error


class DataTransferEngine(Engine):
    """Writes datapacks to files, one for each, ``<dataDirectory>/<number>/<name>-<resets>.data``.

    Args:
        name: its name.
        step_ns: its time step.
        folder: the folder of data.
        names: the datapacks that it writes.
    """

    def __init__(self, name: str, step_ns: int, folder: Path, names: Sequence[str]) -> None:
        super().__init__(name, step_ns)
        self._top, self._names = folder, names
        self._folder: Path | None = None
        self._files: dict[str, TextIO] = {}
        self._resets = self._now_ns = 0

    def initialize(self) -> None:
        """Open nothing: the files are made with their first datapacks."""

    def read(self, names: Iterable[str]) -> Mapping[str, Any]:
        for name in names:
            raise ExperimentError(f"the engine '{self.name}' only writes: it has no datapack '{name}'")
        return {}

    def write(self, packs: Sequence[DataPack]) -> None:
        for pack in packs:
            if pack.name in self._names:
                self._file(pack).write(self._line(pack.data) + "\n")

    def start_step(self) -> None:
        self._now_ns += self.step_ns

    def reset(self) -> None:
        self.shutdown()
        self._resets += 1
        self._now_ns = 0

    def shutdown(self) -> None:
        for file in self._files.values():
            file.close()
        self._files.clear()

    def _file(self, pack: DataPack) -> TextIO:
        if pack.name not in self._files:
            if self._folder is None:
                numbers = (int(one.name) for one in self._top.glob("*") if one.name.isdecimal())
                self._folder = self._top / str(max(numbers, default=-1) + 1)
                self._folder.mkdir(parents=True)
            file = self._folder / f"{pack.name.replace('/', '_')}-{self._resets}.data"
            self._files[pack.name] = file.open("w", encoding="utf-8")
            if isinstance(pack.data, Message) and pack.data.DESCRIPTOR.file.package != "Dump":
                self._files[pack.name].write(f"sim_time,{as_lines(pack.data, header=True)}\n")
        return self._files[pack.name]

    def _line(self, data: Any) -> str:
        """Return a line as NRP-core 4 prints it, with the time in s; shorter before fields."""
        time = f"{self._now_ns / NS_PER_S:.6f}"
        if not isinstance(data, Message):
            return f"{time},{data}"
        kind = data.DESCRIPTOR.full_name
        if kind == "Dump.String":
            return f"{time},{data.string_stream}"
        if kind == "Dump.ArrayFloat":
            return f"{time},{_rows(list(data.float_stream), list(data.dims))}"
        return f"{self._now_ns / NS_PER_S:g},{as_lines(data, header=False)}"


def _rows(values: Sequence[float], dims: Sequence[int]) -> str:
    """Return numbers with the number of their row before each; a matrix has a line for each row."""
    if len(dims) != 2:
        return ",".join(["0", *(f"{one:f}" for one in values)])
    rows, columns = dims
    parts = [values[i * columns : (i + 1) * columns] for i in range(rows)]
    return "".join(f"\n{i}," + ",".join(f"{one:f}" for one in part) for i, part in enumerate(parts))
