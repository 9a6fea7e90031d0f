"""The module ``nest`` for one script."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum
from functools import wraps
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core.errors import NetworkError, did_you_mean
from nrp_pynest.asking import SpatialFunctions
from nrp_pynest.connecting import Ends, pairs
from nrp_pynest.connections import Synapse, Synapses, collected, synapses_between
from nrp_pynest.kernel import Block, Kernel, Nodes
from nrp_pynest.models import CELLS, GENERATORS, RECORDERS, SYNAPSES
from nrp_pynest.native import ProjectionModel
from nrp_pynest.parameters import Parameter, parameter_modules
from nrp_pynest.plots import plot_modules
from nrp_pynest.spatial import Mask, spatial_module

# ruff: noqa: N802 - the names of NEST


_OWN = frozenset({"resolution", "biological_time", "kernel_status", "verbosity"})
"""Properties of the simulator that are attributes of the module, besides those of its status."""


class NestModule(ModuleType):
    """The module: properties of the simulator are its attributes, as in NEST 3."""

    def __setattr__(self, name: str, value: Any) -> None:
        made = vars(self)["_made"]
        if name in made.status or name in _OWN:
            vars(self)["SetKernelStatus"]({name: value})
        elif name in _SETTINGS:
            return
        else:
            super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        made = vars(self)["_made"]
        if name in made.status or name in ("biological_time", "network_size", "num_connections"):
            return vars(self)["GetKernelStatus"](name)
        if name == "kernel_status":
            return vars(self)["GetKernelStatus"]()
        if name in _SETTINGS:
            return _SETTINGS[name]
        message = f"nest.{name} is not supported{did_you_mean(name, tuple(vars(self)))}"
        raise AttributeError(message, name=name, obj=self)


def nest_module(made: Kernel) -> ModuleType:
    """Return the module; its calls create nodes and synapses in a kernel."""
    functions: dict[str, Any] = {}
    for api in (_Interface(made), SpatialFunctions(made)):
        functions |= {
            name: _once_ready(made, getattr(api, name))
            for name in vars(type(api))
            if not name.startswith("_")
        }
    here = NestModule("nest")
    vars(here).update(
        _made=made, __path__=[], **functions, **dict.fromkeys(_QUIET, _nothing), **parameter_modules(),
        spatial=spatial_module(), sli_func=_sli_func, __version__="3.10.0", VerbosityLevel=VerbosityLevel,
        build_info={"have_libneurosim": False, "have_mpi": False, "version": "3.10.0"}, ll_api=here,
        hl_api=here, CreateMask=lambda kind, settings, anchor=(): Mask(kind, settings, anchor),
        CreateParameter=lambda kind, settings: vars(here)["random"].__dict__[kind](**settings),
        CollocatedSynapses=lambda *parts: list(parts), **plot_modules(here),
        NodeCollection=lambda nodes=(): Nodes.of(made, nodes), NestModule=NestModule,
        set=lambda **values: functions["SetKernelStatus"](values), get=functions["GetKernelStatus"],
    )  # fmt: skip
    return here


class VerbosityLevel(IntEnum):
    """The levels of NEST's messages; this module writes none."""

    ALL, DEBUG, STATUS, INFO, PROGRESS, DEPRECATED, WARNING, ERROR, FATAL, QUIET = range(10)


_SETTINGS: Mapping[str, Any] = {
    "verbosity": VerbosityLevel.INFO, "use_wfr": False, "wfr_tol": 1e-4, "wfr_max_iterations": 15,
    "wfr_comm_interval": 1.0, "wfr_interpolation_order": 3, "keep_source_table": True,
    "sort_connections_by_source": True, "use_compressed_spikes": True, "recording_backends": (),
    "memory_size": 0, "structural_plasticity_update_interval": 1e4, "tics_per_ms": 1000.0,
}  # fmt: skip
"""Properties of NEST that have no effect here."""
_QUIET = (
    "set_verbosity", "sli_run", "sr", "sli_push", "Install", "Prepare", "Cleanup", "CatchInterrupt",
    "M_WARNING", "M_ERROR", "M_FATAL", "M_INFO", "M_QUIET", "PrintNetwork", "PrintNodes", "Rank",
    "SyncProcesses", "DisableStructuralPlasticity", "SetStructuralPlasticityStatus",
    "EnableStructuralPlasticity", "message",
)  # fmt: skip
"""Functions that do nothing here."""


_BRANCHES = {"LambertW0": 0, "LambertWm1": -1}
"""Functions of NEST's own language that brains call, to scale synaptic potentials."""


def _sli_func(name: str, *values: float) -> float:
    """Return the result of a function of NEST's own language."""
    if name not in _BRANCHES:
        raise AttributeError(f"nest.sli_func('{name}', ...) is not supported{did_you_mean(name, _BRANCHES)}")
    from scipy.special import lambertw

    return float(lambertw(*values, k=_BRANCHES[name]).real)


class _Interface:
    """The functions of the module."""

    def __init__(self, made: Kernel) -> None:
        self._made = made

    def Create(self, model: str, n: int = 1, params: Any = None, positions: Any = None) -> Nodes:
        """Create nodes."""
        if isinstance(n, Mapping):
            n, params = 1, n
        if positions is None:
            return self._made.create(str(model), int(n), params)
        layer = positions.layer(int(n), self._made.random)
        return self._made.create(str(model), len(layer.positions), params, layer)

    def SetStatus(self, nodes: Any, params: Any, val: Any = None) -> None:
        """Set parameters of nodes or synapses: ``params`` may be a name and ``val`` its values."""
        given = {params: val} if isinstance(params, str) else params
        if _are_synapses(nodes):
            collected(nodes).set(given)
        elif _several(nodes):
            whole = given[0] if isinstance(given, (list, tuple)) and len(given) == 1 else given
            self._made.set_nodes(_several(nodes), whole)

    def GetStatus(self, nodes: Any, keys: Any = None, output: str = "") -> Any:
        """Return parameters of nodes or synapses."""
        if _are_synapses(nodes):
            found = list(collected(nodes).rows())
        else:
            found = [self._made.node_values(one) for one in _several(nodes)]
        if keys is None:
            return tuple(found)
        if isinstance(keys, str):
            return tuple(one.get(keys) for one in found)
        return tuple(tuple(one.get(key) for key in keys) for one in found)

    def Connect(
        self, pre: Any, post: Any, conn_spec: Any = None, syn_spec: Any = None, *more: Any,
        model: Any = None, params: Any = None, delay: Any = None, return_synapsecollection: bool = False,
        **_options: Any,
    ) -> Any:  # fmt: skip
        """Connect nodes; also in the old form ``Connect(pre, post, weight, delay, model)``."""
        if isinstance(syn_spec, list):  # several synapses for each pair
            for one in syn_spec:
                self.Connect(pre, post, conn_spec, one)
            return None
        if isinstance(syn_spec, ProjectionModel):
            syn_spec.connect(_several(pre), _several(post), conn_spec)
            return None
        sources, targets = _several(pre), _several(post)
        if isinstance(conn_spec, (int, float, np.number)) or _is_plain_list(conn_spec):
            rule, given = "one_to_one", {"weight": conn_spec, "delay": syn_spec if delay is None else delay}
            name = more[0] if more else model
        else:
            rule, given = conn_spec or "all_to_all", dict(params or {})
            if isinstance(syn_spec, Mapping):
                given.update(syn_spec)
            name = given.pop("model", given.pop("synapse_model", None)) or (
                syn_spec if isinstance(syn_spec, str) else model
            )
        options = dict(rule) if isinstance(rule, Mapping) else {"rule": rule}
        block = self._connect(sources, targets, options, str(name or "static_synapse"), given)
        every = [(block, np.arange(len(block.pre)))]
        return Synapses(self._made, every) if return_synapsecollection else None

    def ConvergentConnect(
        self, pre: Any, post: Any, weight: Any = None, delay: Any = None, model: Any = None
    ) -> None:
        """Connect all to all."""
        given = {"weight": weight, "delay": delay}
        self._connect(_several(pre), _several(post), {}, str(model or "static_synapse"), given)

    DivergentConnect = ConvergentConnect

    def _connect(self, pre: Any, post: Any, rule: dict[str, Any], name: str, given: dict[str, Any]) -> Block:
        made = self._made
        sources, targets = (np.array(list(map(int, nodes)), dtype=np.int64) for nodes in (pre, post))
        spatial = [value for value in (*rule.values(), *given.values()) if isinstance(value, Parameter)]
        where = made.positions_of if spatial or "mask" in rule else _nowhere
        layer = made.group_of(int(pre[0])).layer if where is not _nowhere and len(pre) else None
        same = len(pre) == len(post) and bool((sources == targets).all())
        ends = Ends(len(pre), len(post), same, where(sources.tolist()), where(targets.tolist()), layer)
        i, j = pairs(rule, ends, made.random)

        def weave(value: Any) -> Any:
            array = np.asarray(value, dtype=float)
            if array.size == 1:
                return array.reshape(())
            if array.ndim == 2 and array.shape == (len(targets), len(sources)):  # rows are targets
                return array[j, i]
            if array.size == len(i):
                return array.ravel()
            raise NetworkError(f"nest: {array.size} values for {len(i)} synapses")

        values = {key: value for key, value in given.items() if value is not None}
        places = ends.places(i, j, made.random)
        if rule.get("make_symmetric"):
            made.connect(targets[j], sources[i], name, values, places, weave)
        return made.connect(sources[i], targets[j], name, values, places, weave)

    def GetConnections(
        self, source: Any = None, target: Any = None, synapse_model: Any = None, **_more: Any
    ) -> Synapses:
        """Return the synapses between nodes."""
        sources, targets = (None if nodes is None else _several(nodes) for nodes in (source, target))
        return synapses_between(self._made, sources, targets, synapse_model)

    def GetNodes(self, properties: Mapping[str, Any] | None = None, **_more: Any) -> Nodes:
        """Return all nodes that have some properties."""
        wanted = dict(properties or {})
        every = (node for group in self._made.groups for node in range(group.first, group.first + group.size))
        if not wanted:
            return Nodes.of(self._made, every)
        values = ((node, self._made.node_values(node)) for node in every)
        return Nodes.of(
            self._made, [node for node, own in values if all(own.get(k) == v for k, v in wanted.items())]
        )

    def SetDefaults(self, model: str, params: Any, val: Any = None) -> None:
        """Change the defaults of a model."""
        self._made.set_defaults(model, {params: val} if isinstance(params, str) else params)

    def GetDefaults(self, model: str, keys: Any = None) -> Any:
        """Return the defaults of a model."""
        values = self._made.defaults(model)
        if isinstance(keys, str):
            return values.get(keys)
        return values if keys is None else [values.get(key) for key in keys]

    def CopyModel(self, existing: str, new: str, params: Any = None) -> None:
        """Create a model from another one."""
        self._made.copy(existing, new, params or {})

    def Models(self, *_values: Any, **_fields: Any) -> list[str]:
        """Return the names of all models."""
        return sorted({*CELLS, *GENERATORS, *RECORDERS, *SYNAPSES})

    def ResetKernel(self) -> None:
        """Remove everything."""
        self._made.clear()

    def ResetNetwork(self) -> None:
        """Do nothing, because nothing has run."""

    def SetKernelStatus(self, params: Mapping[str, Any]) -> None:
        """Set properties of the simulator; the resolution is that of the network."""
        self._made.set_status(params)

    def GetKernelStatus(self, keys: Any = None) -> Any:
        """Return properties of the simulator."""
        made = self._made
        values = {
            **made.status,
            **made.now(),
            "network_size": sum(group.size for group in made.groups) + made.is_lenient,
            "num_connections": sum(len(block.pre) for block in made.blocks),
        }
        if isinstance(keys, str):
            return values.get(keys)
        return values if keys is None else tuple(values.get(key) for key in keys)

    def NumProcesses(self) -> int:
        """Return 1."""
        return 1

    def Simulate(self, t: float) -> None:
        """Run the network for ``t`` ms; in a brain file nothing, because the experiment runs it."""
        self._made.simulate(float(t))

    Run = Simulate


def _once_ready(made: Kernel, function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def call(*values: Any, **fields: Any) -> Any:
        made.ready()
        return function(*values, **fields)

    return call


def _nowhere(_nodes: Any) -> None:
    return None


def _nothing(*_values: Any, **_fields: Any) -> int:
    return 0


def _several(nodes: Any) -> Any:
    """Return nodes or synapses, possibly a single one, as a sequence."""
    if isinstance(nodes, (int, np.integer)):
        return [nodes]
    if isinstance(nodes, Synapse):
        return [nodes]
    if _are_cells(nodes):
        return nodes.nodes()
    if isinstance(nodes, (list, tuple)) and any(map(_are_cells, nodes)):
        return [node for one in nodes for node in _several(one)]
    return nodes


def _are_cells(value: Any) -> bool:
    """Return whether a value is cells of a running brain, which know their nodes."""
    return hasattr(type(value), "nodes")  # not of the value, which has every attribute


def _are_synapses(items: Any) -> bool:
    if isinstance(items, (Synapse, Synapses)):
        return True
    several = _several(items)
    return not isinstance(several, Nodes) and len(several) > 0 and isinstance(several[0], Synapse)


def _is_plain_list(value: Any) -> bool:
    return isinstance(value, (list, tuple, np.ndarray)) and not isinstance(value, Nodes)
