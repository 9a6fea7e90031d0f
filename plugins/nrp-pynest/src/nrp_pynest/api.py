"""The module ``nest`` for one brain file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import wraps
from types import ModuleType
from typing import Any, NamedTuple, NoReturn

import numpy as np

from nrp_core.brain import IntArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.findings import Code
from nrp_pynest.kernel import Block, Kernel, Node, Nodes, exponential, lognormal, normal, uniform
from nrp_pynest.models import CELLS, GENERATORS, RECORDERS, SYNAPSES
from nrp_pynest.native import ProjectionModel

RULES = (
    "all_to_all", "one_to_one", "fixed_indegree", "fixed_outdegree", "fixed_total_number",
    "pairwise_bernoulli",
)  # fmt: skip


def pairs(
    rule: Mapping[str, Any], n_pre: int, n_post: int, random: np.random.RandomState, *, same: bool
) -> tuple[IntArray, IntArray]:
    """Return indices of sources and targets, one pair per synapse.

    Args:
        rule: its name and settings, as ``conn_spec``.
        n_pre: number of sources.
        n_post: number of targets.
        random: the random generator.
        same: whether sources are the targets, for rules without autapses.

    Raises:
        NetworkError: the rule is unknown, or the numbers do not fit.
    """
    name = str(rule.get("rule", "all_to_all"))
    if name not in RULES:
        raise NetworkError(f"nest: the connection rule '{name}' is not supported{did_you_mean(name, RULES)}")
    autapses = bool(rule.get("autapses", rule.get("allow_autapses", True))) or not same
    multapses = bool(rule.get("multapses", rule.get("allow_multapses", True)))
    if name == "one_to_one":
        if n_pre != n_post:
            raise NetworkError(
                f"nest: one_to_one needs equal numbers of sources and targets, not {n_pre} and {n_post}"
            )
        return np.arange(n_pre), np.arange(n_pre)
    if name in ("fixed_indegree", "fixed_outdegree"):
        inward = name == "fixed_indegree"
        degree = int(rule["indegree" if inward else "outdegree"])
        far, near = (n_pre, n_post) if inward else (n_post, n_pre)
        drawn = _degree(degree, far, near, random, autapses=autapses, multapses=multapses)
        return drawn if inward else drawn[::-1]
    if name == "fixed_total_number":
        total = int(rule["N"])
        return random.randint(0, n_pre, total), random.randint(0, n_post, total)
    post, pre = np.divmod(np.arange(n_pre * n_post), max(n_pre, 1))  # target by target, as NEST
    chosen = np.ones(len(pre), bool) if autapses else pre != post
    if name == "pairwise_bernoulli":
        chosen &= random.uniform(size=len(pre)) < float(rule["p"])
    return pre[chosen], post[chosen]


def _degree(
    degree: int, far: int, near: int, random: np.random.RandomState, *, autapses: bool, multapses: bool
) -> tuple[IntArray, IntArray]:
    drawn = []
    for i in range(near):
        choices = np.arange(far) if autapses else np.delete(np.arange(far), i)
        if not multapses and degree > len(choices):
            raise NetworkError(f"nest: cannot draw {degree} different nodes from {len(choices)}")
        drawn.append(random.choice(choices, degree, replace=multapses))
    return np.concatenate([np.empty(0, np.int64), *drawn]), np.repeat(np.arange(near), degree)


# ruff: noqa: N802 - the names of NEST


class Synapse(NamedTuple):
    """A synapse as ``GetConnections`` returns it, with the array that contains it."""

    source: int
    target: int
    target_thread: int
    synapse_id: int
    port: int
    block: Block
    place: int


class Synapses(tuple[Synapse, ...]):
    """Synapses, with the methods of NEST 3."""

    __slots__ = ()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or not self or name not in _synapse_values(self[0]):
            raise AttributeError(f"synapses do not have the attribute '{name}'")
        return self.get(name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.set({name: value})

    def set(self, params: Any = None, **fields: Any) -> None:
        """Set parameters."""
        _set_synapses(self, {**(params or {}), **fields})

    def get(self, name: str) -> Any:
        """Return a parameter of each."""
        if self:
            self[0].block.kernel.read_weights()
        return tuple(_synapse_values(one).get(name) for one in self)


def nest_module(made: Kernel) -> ModuleType:
    """Return the module; its calls create nodes and synapses in a kernel."""
    api = _Interface(made)
    functions = {
        name: _once_ready(made, getattr(api, name)) for name in vars(_Interface) if not name.startswith("_")
    }
    quiet = dict.fromkeys(_QUIET, _nothing)
    random, here = ModuleType("nest.random"), ModuleType("nest")
    vars(random).update(uniform=uniform, normal=normal, lognormal=lognormal, exponential=exponential)
    vars(here).update(**functions, **quiet, random=random, sli_func=_sli_func, __version__="2.18.0")
    vars(here).update(ll_api=here, hl_api=here, NodeCollection=lambda nodes: Nodes.of(made, nodes))
    vars(here)["__getattr__"] = _unknown(tuple(vars(here)))
    return here


_QUIET = (
    "set_verbosity", "sli_run", "sr", "sli_push", "Install", "Prepare", "Cleanup", "CatchInterrupt",
    "M_WARNING", "M_ERROR", "M_FATAL", "M_INFO", "M_QUIET", "PrintNetwork", "PrintNodes", "Rank",
    "SyncProcesses", "DisableStructuralPlasticity", "SetStructuralPlasticityStatus",
    "EnableStructuralPlasticity",
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
        return self._made.create(str(model), int(n), params)

    def SetStatus(self, nodes: Any, params: Any, val: Any = None) -> None:
        """Set parameters of nodes or synapses: ``params`` may be a name and ``val`` its values."""
        given = {params: val} if isinstance(params, str) else params
        if _are_synapses(nodes):
            _set_synapses(_several(nodes), given)
        elif _several(nodes):
            whole = given[0] if isinstance(given, (list, tuple)) and len(given) == 1 else given
            self._made.set_nodes(_several(nodes), whole)

    def GetStatus(self, nodes: Any, keys: Any = None, output: str = "") -> Any:
        """Return parameters of nodes or synapses."""
        if are_synapses := _are_synapses(nodes):
            self._made.read_weights()
        values = _synapse_values if are_synapses else self._made.node_values
        found = [values(one) for one in _several(nodes)]
        if keys is None:
            return tuple(found)
        if isinstance(keys, str):
            return tuple(one.get(keys) for one in found)
        return tuple(tuple(one.get(key) for key in keys) for one in found)

    def Connect(
        self, pre: Any, post: Any, conn_spec: Any = None, syn_spec: Any = None, *more: Any,
        model: Any = None, params: Any = None, delay: Any = None, **_options: Any,
    ) -> None:  # fmt: skip
        """Connect nodes; also in the old form ``Connect(pre, post, weight, delay, model)``."""
        if isinstance(syn_spec, ProjectionModel):
            syn_spec.connect(_several(pre), _several(post), conn_spec)
            return
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
        self._connect(sources, targets, options, str(name or "static_synapse"), given)

    def ConvergentConnect(
        self, pre: Any, post: Any, weight: Any = None, delay: Any = None, model: Any = None
    ) -> None:
        """Connect all to all."""
        given = {"weight": weight, "delay": delay}
        self._connect(_several(pre), _several(post), {}, str(model or "static_synapse"), given)

    DivergentConnect = ConvergentConnect

    def _connect(self, pre: Any, post: Any, rule: dict[str, Any], name: str, given: dict[str, Any]) -> None:
        i, j = pairs(rule, len(pre), len(post), self._made.random, same=list(pre) == list(post))
        sources, targets = (np.array(list(map(int, nodes)), dtype=np.int64) for nodes in (pre, post))

        def weave(value: Any) -> Any:
            array = np.asarray(value, dtype=float)
            if array.size == 1:
                return array.reshape(())
            if array.ndim == 2:  # rows are targets
                return array[j, i]
            if array.size == len(i):
                return array
            raise NetworkError(f"nest: {array.size} values for {len(i)} synapses")

        values = {key: value for key, value in given.items() if value is not None}
        self._made.connect(sources[i], targets[j], name, values, weave)

    def GetConnections(
        self, source: Any = None, target: Any = None, synapse_model: Any = None, **_more: Any
    ) -> Synapses:
        """Return the synapses between nodes."""
        found: list[Synapse] = []
        for number, block in enumerate(self._made.blocks):
            if synapse_model is not None and block.model != synapse_model:
                continue
            chosen = _among(block.pre, source) & _among(block.post, target)
            found += (
                Synapse(int(block.pre[k]), int(block.post[k]), 0, number, k, block, k)
                for k in np.flatnonzero(chosen).tolist()
            )
        return Synapses(found)

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
        self._made.status.update(params)

    def GetKernelStatus(self, keys: Any = None) -> Any:
        """Return properties of the simulator."""
        values = {
            **self._made.status,
            **self._made.now(),
            "network_size": sum(group.size for group in self._made.groups) + 1,
        }
        if isinstance(keys, str):
            return values.get(keys)
        return values if keys is None else tuple(values.get(key) for key in keys)

    def NumProcesses(self) -> int:
        """Return 1."""
        return 1

    def Simulate(self, t: float) -> None:
        """Do nothing, because the experiment runs the network."""
        message = "the brain file calls Simulate: ignored, because the experiment runs the network"
        self._made.notes.add(Code.NRP217, message, subject="Simulate")

    Run = Simulate


def _once_ready(made: Kernel, function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def call(*values: Any, **fields: Any) -> Any:
        made.ready()
        return function(*values, **fields)

    return call


def _nothing(*_values: Any, **_fields: Any) -> int:
    return 0


def _unknown(names: tuple[str, ...]) -> Callable[[str], NoReturn]:
    def attribute(name: str) -> NoReturn:
        raise AttributeError(f"nest.{name} is not supported{did_you_mean(name, names)}")

    return attribute


def _several(nodes: Any) -> Any:
    """Return nodes or synapses, possibly a single one, as a sequence."""
    if isinstance(nodes, (int, np.integer)):
        return [Node(nodes)]
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
    several = _several(items)
    return len(several) > 0 and isinstance(several[0], Synapse)


def _is_plain_list(value: Any) -> bool:
    return isinstance(value, (list, tuple, np.ndarray))


def _among(nodes: IntArray, wanted: Any) -> Any:
    return np.ones(len(nodes), bool) if wanted is None else np.isin(nodes, list(map(int, _several(wanted))))


def _synapse_values(synapse: Synapse) -> dict[str, Any]:
    block, place = synapse.block, synapse.place
    values = {name: float(column[place]) for name, column in block.values.items()}
    return {"source": synapse.source, "target": synapse.target, "synapse_model": block.model, **values}


def _set_synapses(synapses: Sequence[Synapse], given: Any) -> None:
    with synapses[0].block.kernel.changing() if synapses else nullcontext():
        for i, synapse in enumerate(synapses):
            own = given if isinstance(given, Mapping) else given[i]
            for name, value in own.items():
                column = synapse.block.values.setdefault(name, np.full(len(synapse.block.pre), np.nan))
                column[synapse.place] = value[i] if _is_plain_list(value) else value
