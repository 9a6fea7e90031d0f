"""NEST engines: their files become one network, and their datapacks read and set its nodes while it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from nrp_legacy.brains import NotedNetwork, connect_nest
from nrp_pynest.api import nest_module
from nrp_pynest.built import BuiltBrain
from nrp_pynest.kernel import random_of
from nrp_pynest.network import network_of
from nrp_pynest.running import RunningKernel

from nrp_core.brain import Network
from nrp_core.errors import ExperimentError, NetworkError, did_you_mean
from nrp_core.network.files.script import seeded_generators
from nrp_core.seeds import Seeds
from nrp_ebrains.datapacks import DataPack, JsonData, plain
from nrp_ebrains.loop import Engine
from nrp_ebrains.modules import module, scope_with

KERNEL = "kernel"
"""The datapack with the state of the simulator, which every NEST engine has."""
_LEAKY = {"V_th": 1e10, "C_m": 1000.0, "E_L": 0.0, "V_reset": 0.0, "V_m": 0.0, "t_ref": 0.1, "I_e": 0.0}
_ALPHA = {**_LEAKY, "tau_m": 10.0, "tau_syn_ex": 2.0, "tau_syn_in": 2.0}
_EXP = {**_LEAKY, "tau_m": 20.0, "tau_syn_ex": 0.5, "tau_syn_in": 0.5}
# weights and parameters: brain_devices.py of NRP-core 1.4.1
_POISSON = {"synapse_model": "static_synapse", "weight": 0.15, "delay": 0.1}
_TO_LEAKY = {"synapse_model": "static_synapse", "weight": 10.0}


class InitFile(NamedTuple):
    """The file that builds the network of an engine.

    Args:
        engine: the name of the engine.
        path: the file.
        is_server: whether it is for ``nest_server``, whose files name their datapacks in ``populations``.
    """

    engine: str
    path: Path
    is_server: bool


class NestObjects(BuiltBrain):
    """The objects of all NEST files.

    Attributes:
        datapacks: the nodes of each datapack, by engine and name.
    """

    def __init__(self) -> None:
        super().__init__()
        self.datapacks: dict[str, dict[str, Any]] = {}


def build_network(files: Sequence[InitFile], seed: int) -> Network:
    """Return one network with the nodes of all files.

    Args:
        files: the files, in the order of their engines.
        seed: the seed of random numbers.

    Raises:
        NetworkError: a file is wrong.
    """
    built = NestObjects()
    kernel = RunningKernel(random_of(seed), built, is_lenient=True)
    nest = nest_module(kernel)
    built.nest = nest
    built.on_begin.append(kernel.begin)
    for file in files:
        built.datapacks[file.engine] = _execute(file, nest, seed)
    network = network_of(kernel, {})
    parts = network.populations, network.projections, network.views, network.timestep_ms
    connect_nest(built, kernel, network)
    return NotedNetwork(*parts, tuple(kernel.notes), (), built, remarks=network.remarks)


def _execute(file: InitFile, nest: ModuleType, seed: int) -> dict[str, Any]:
    """Execute a file, and return the nodes of its datapacks."""
    datapacks: dict[str, Any] = {}
    own = ModuleType("nest")  # each engine had a kernel of its own, so a reset leaves those of others
    vars(own).update(vars(nest), ResetKernel=lambda: None)
    engine = "nrp_core.engines.nest_server" if file.is_server else "nrp_core.engines.nest_json"
    devices = module(f"{engine}.brain_devices", _devices(None if file.is_server else datapacks))
    registry = {} if file.is_server else _registry(own, datapacks)
    modules = {
        "nest": own,
        "nest.voltage_trace": module("nest.voltage_trace", {"from_device": lambda *_nodes: None}),
        engine: module(engine, {**registry, "brain_devices": devices}),
        f"{engine}.brain_devices": devices,
    }
    scope = scope_with({}, modules)
    prepared = ModuleType(file.path.stem)
    vars(prepared).update(nest=own, nrp_core=scope.substitute("nrp_core"), **registry)
    try:
        with seeded_generators(Seeds(seed).integer("script")):
            scope.run(file.path, module=prepared)
    except (Exception, SystemExit) as error:
        raise scope.located(error, NetworkError, file.path) from error
    if file.is_server:
        datapacks.update(vars(prepared).get("populations", {}))
    return datapacks


def _registry(nest: ModuleType, datapacks: dict[str, Any]) -> dict[str, Callable[..., Any]]:
    def register(name: str, nodes: Any) -> None:
        if name in datapacks or name == KERNEL:
            raise NetworkError(f"the datapack '{name}' is already registered")
        datapacks[name] = nodes

    def create(name: str, *given: Any, **more: Any) -> Any:
        nodes = nest.Create(*given, **more)
        register(name, nodes)
        return nodes

    return {"RegisterDataPack": register, "CreateDataPack": create}


def _devices(datapacks: dict[str, Any] | None) -> dict[str, Callable[..., Any]]:
    """Return the devices; those of ``nest_server`` take no name and return their nodes."""

    def device(make: Callable[..., Any]) -> Callable[..., Any]:
        def server(nest: ModuleType, neurons: Any, n: int = 1, conn_spec: Any = "all_to_all") -> Any:
            return make(nest, neurons, n, conn_spec)

        def named(
            nest: ModuleType, name: str, neurons: Any, n: int = 1, conn_spec: Any = "all_to_all"
        ) -> None:
            assert datapacks is not None
            datapacks[name] = make(nest, neurons, n, conn_spec)

        return server if datapacks is None else named

    return {
        "PoissonSpikeGenerator": device(_poisson),
        "DCSource": device(_direct_current),
        "LeakyIntegratorAlpha": device(_leaky_alpha),
        "LeakyIntegratorExp": device(_leaky_exp),
    }


def _poisson(nest: ModuleType, neurons: Any, n: int, conn_spec: Any) -> Any:
    generators = nest.Create("poisson_generator", n)
    nest.Connect(generators, neurons, conn_spec, dict(_POISSON))
    return generators


def _direct_current(nest: ModuleType, neurons: Any, n: int, conn_spec: Any) -> Any:
    generators = nest.Create("dc_generator", n)
    nest.Connect(generators, neurons, conn_spec)
    return generators


def _leaky_alpha(nest: ModuleType, neurons: Any, n: int, conn_spec: Any) -> Any:
    cells = nest.Create("iaf_psc_alpha", n, dict(_ALPHA))
    nest.Connect(neurons, cells, conn_spec, {**_TO_LEAKY, "delay": 0.1})
    return cells


def _leaky_exp(nest: ModuleType, neurons: Any, n: int, conn_spec: Any) -> Any:
    cells = nest.Create("iaf_psc_exp", n, dict(_EXP))
    delay = {"distribution": "uniform", "low": 0.1, "high": 2.0}
    nest.Connect(neurons, cells, conn_spec, {**_TO_LEAKY, "delay": delay})
    return cells


class NestEngine(Engine):
    """The nodes of one engine in the brain of a run, which advances with the run.

    Args:
        name: its name.
        step_ns: its time step.
        built: the objects of the files.
    """

    def __init__(self, name: str, step_ns: int, built: NestObjects) -> None:
        super().__init__(name, step_ns)
        self._built = built
        assert built.nest is not None
        self._nest = built.nest
        self._nodes = built.datapacks[name]

    def initialize(self) -> None:
        """Do nothing, because the file has been executed."""

    def read(self, names: Iterable[str]) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for name in names:
            if name == KERNEL:
                found[name] = JsonData(plain(self._nest.GetKernelStatus()))
            else:
                found[name] = JsonData([plain(one) for one in self._nest.GetStatus(self._of(name))])
        return found

    def write(self, packs: Sequence[DataPack]) -> None:
        for pack in packs:
            values = plain(pack.data)
            if values:
                self._nest.SetStatus(self._of(pack.name), values)

    def _of(self, name: str) -> Any:
        if name not in self._nodes:
            raise ExperimentError(
                f"the NEST engine '{self.name}' has no datapack '{name}'"
                f"{did_you_mean(name, (*self._nodes, KERNEL))}"
            )
        return self._nodes[name]
