"""Writes networks as files of NIR."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np

from nrp_core.brain import STATIC, FloatArray, Network, Population, Projection
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.paths import check_free, path_of
from nrp_core.utilities import checks_arguments, replacing
from nrp_formats.nir.graph import returning
from nrp_formats.nir.neurons import Step, driven_by

CELL_TYPES: Final = ("IF_curr_delta", "IF_curr_exp")
_NO_LEAK_MS: Final = 1e12
"""A time constant from which a cell is written without leak."""
_ROUNDING: Final = 1e-9


def node_of(population: Population, step: Step) -> tuple[Any, FloatArray]:
    """Return the node of a population of cells, and the constant input of each of them.

    Raises:
        ValueError: no node has the dynamics of these cells.
    """
    if population.cell_type not in CELL_TYPES:
        raise ValueError(f"NIR has no node for its cell type; it has those of {' and '.join(CELL_TYPES)}")
    _require_start_at_rest(population)
    make = _current_based if population.cell_type == "IF_curr_exp" else _delta
    return make({name: np.array(values) for name, values in population.parameters.items()}, step)


def refractory_steps(population: Population, step: Step) -> int:
    """Return the steps for which the cells of a population stay at reset.

    Raises:
        ValueError: they differ, or are not whole steps.
    """
    steps = population.parameters["tau_refrac"] / step.h_ms
    whole = np.rint(steps)
    wrong = np.abs(steps - whole) > _ROUNDING
    if wrong.any():
        found = float(population.parameters["tau_refrac"][wrong][0])
        raise ValueError(f"tau_refrac is {found:g} ms, which is not a multiple of the step, {step.h_ms:g} ms")
    if len(np.unique(whole)) > 1:
        raise ValueError(
            f"tau_refrac is from {whole.min():g} to {whole.max():g} steps; NIR has no refractory period, and "
            "the remark for readers holds one number"
        )
    return int(whole[0])


def _require_start_at_rest(population: Population) -> None:
    rest = {"v": population.parameters["v_rest"]}
    for name, values in population.initial_values.items():
        wrong = np.abs(values - rest.get(name, 0.0)) > _ROUNDING
        if wrong.any():
            raise ValueError(
                f"NIR has no initial values, and {name} of cell {int(np.argmax(wrong))} starts at "
                f"{values[wrong][0]:g}; give it the value at rest by initialize({name}=...)"
            )


def _delta(given: dict[str, FloatArray], step: Step) -> tuple[Any, FloatArray]:
    """Return a node LIF, or IF if no cell leaks."""
    import nir

    leaks = given["tau_m"] < _NO_LEAK_MS
    threshold, reset = _limits(given)
    if not leaks.any():
        ones = np.ones(len(leaks))
        bias = given["i_offset"] * step.h_ms / given["cm"]
        return nir.IF(r=ones / step.dt_s, v_threshold=threshold, v_reset=reset), bias
    decay = np.exp(-step.h_ms / given["tau_m"])
    tau = step.tau_s(given["tau_m"])
    rise = (1.0 - decay) * given["tau_m"] / given["cm"]  # mV in a step by 1 nA
    bias = given["i_offset"] * (rise if step.method == "euler" else step.h_ms / given["cm"])
    node = nir.LIF(
        tau=tau, r=tau / step.dt_s, v_leak=np.zeros(len(tau)), v_threshold=threshold, v_reset=reset
    )
    return node, bias


def _current_based(given: dict[str, FloatArray], step: Step) -> tuple[Any, FloatArray]:
    """Return a node CubaLIF."""
    import nir

    if not np.array_equal(given["tau_syn_E"], given["tau_syn_I"]):
        raise ValueError("a node CubaLIF has one tau_syn, and tau_syn_E differs from tau_syn_I")
    constant = given["i_offset"][given["i_offset"] != 0]
    if constant.size:
        raise ValueError(
            f"i_offset is {constant[0]:g} nA, and all inputs of a node CubaLIF pass through its tau_syn; "
            "drive the cells by a source, or use IF_curr_delta"
        )
    tau, tau_syn = step.tau_s(given["tau_m"]), step.tau_s(given["tau_syn_E"])
    if step.method == "euler":
        area = driven_by(step.h_ms, given["tau_m"], given["tau_syn_E"])
        r = area / given["cm"] * tau / step.dt_s
    else:
        r = given["tau_m"] / given["cm"]
    threshold, reset = _limits(given)
    node = nir.CubaLIF(
        tau_syn=tau_syn, tau_mem=tau, r=r, v_leak=np.zeros(len(tau)), v_threshold=threshold, v_reset=reset,
        w_in=tau_syn / step.dt_s,
    )  # fmt: skip
    return node, np.zeros(len(tau))


def _limits(given: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the thresholds, above which cells of NIR fire, and the reset voltages."""
    threshold = np.nextafter(given["v_thresh"] - given["v_rest"], -np.inf)
    return threshold, given["v_reset"] - given["v_rest"]


_MOST_WEIGHTS: Final = 10**8
"""The largest dense matrix that is written; it has 0.8 GB."""


Written = Literal["exact", "euler"]


@checks_arguments("method")
def save_nir(
    network: Network, path: Path | str, *, method: Written = "exact", overwrite: bool = False
) -> None:
    """Write a network of cells that NIR has: ``IF_curr_delta`` and ``IF_curr_exp`` with static synapses.

    Sources become inputs; populations that excite no other become outputs. A step of the file is the time
    step of the network; the metadata of the file name it, the method and the refractory steps.

    Args:
        network: the network.
        path: the file.
        overwrite: whether to replace an existing file.
        method: ``exact`` if readers solve the equations of NIR; ``euler`` if their states decay by
            ``1 - dt/tau`` in a step, as in snnTorch: time constants and weights are then such that a step
            has the same result.

    Raises:
        NetworkError: NIR has no node for something in the network, or the file cannot be written.
    """
    import nir

    path = path_of(path, NetworkError)
    check_free(path, overwrite=overwrite, error=NetworkError)
    if method not in get_args(Written):
        raise NetworkError(f"save_nir: method is '{method}'{did_you_mean(str(method), get_args(Written))}")
    if network.timestep_ms is None:
        raise NetworkError("save_nir: the network has no time step, which a file of NIR needs")
    if network.currents:
        raise NetworkError("save_nir: NIR has no currents that change, which flow into cells of the network")
    dt_s = network.timestep_ms * 1e-3
    graph = _Writer(nir, network, Step(dt_s, network.timestep_ms, method)).graph()
    try:
        with replacing(path) as draft:
            nir.write(draft, graph)
    except OSError as error:
        raise NetworkError(f"the network cannot be written: {error}", path=path) from error


class _Writer:
    def __init__(self, nir: Any, network: Network, step: Step) -> None:
        self._nir, self._network, self._step = nir, network, step
        self._nodes: dict[str, Any] = {}
        self._edges: list[tuple[str, str]] = []
        self._refractory: dict[str, int] = {}

    def graph(self) -> Any:
        """Return the graph."""
        biases = {label: self._emitter(label) for label in self._network.populations}
        self._inputs = [label for label in biases if label not in self._refractory]
        if not self._inputs:
            raise NetworkError("save_nir: a network without sources has no input, and NIR demands one")
        self._connect({label: biases[label] for label in self._refractory})
        self._end()
        return self._nir.NIRGraph(self._nodes, self._edges, self._metadata(), type_check=False)

    def _emitter(self, label: str) -> FloatArray:
        """Add the node of a population; return the constant input of each of its cells."""
        population = self._network.populations[label]
        if "/" in label or not label:
            raise NetworkError(f"population '{label}': the name of a node cannot be empty or contain '/'")
        if population.is_source:
            self._nodes[label] = self._nir.Input(np.array([population.size]))
            return np.zeros(population.size)
        try:
            self._nodes[label], bias = node_of(population, self._step)
            self._refractory[label] = refractory_steps(population, self._step)
        except ValueError as error:
            raise NetworkError(f"population '{label}' ({population.cell_type}): {error}") from error
        return bias

    def _metadata(self) -> dict[str, Any]:
        if len(set(self._refractory.values())) > 1:
            each = ", ".join(f"'{label}' {n}" for label, n in self._refractory.items())
            raise NetworkError(
                "save_nir: NIR has no refractory period, and the metadata for readers hold one number of "
                f"steps for all populations, not {each}"
            )
        steps = next(iter(self._refractory.values()), 0)
        return {"dt": self._step.dt_s, "method": self._step.method, "refractory": steps}

    def _connect(self, biases: dict[str, FloatArray]) -> None:
        """Add a matrix for each pair of populations and delay; biases go to the first of a population."""
        pairs: dict[tuple[str, str], list[Projection]] = {}
        for projection in self._network.projections:
            change = projection.synapse_type if projection.rewiring is None else "they form and vanish"
            if change != STATIC:
                raise NetworkError(
                    f"projection '{projection.label}': its synapses change ({change}), and "
                    "those of NIR do not"
                )
            if projection.neuromodulation is not None:
                raise NetworkError(
                    f"projection '{projection.label}': its spikes are a {projection.receptor}, and those of "
                    "NIR are inputs"
                )
            pairs.setdefault((projection.pre, projection.post), []).append(projection)
        back = returning(sorted(self._network.populations), pairs)  # readers get nodes in this order
        for (pre, post), projections in pairs.items():
            for delay_steps, weights in self._matrices(pre, post, projections).items():
                bias = biases.pop(post, np.zeros(0))
                extra = self._own_steps(post) - ((pre, post) in back)
                self._linear(pre, post, weights, bias, delay_steps + extra)
        for label, bias in biases.items():  # nothing reaches these
            pre = self._inputs[0]
            shape = (len(bias), self._network.populations[pre].size)
            self._linear(pre, label, np.zeros(shape), bias, 0)

    def _own_steps(self, label: str) -> int:
        """Return the steps, beyond its delay, before an input acts here."""
        current_based = self._network.populations[label].cell_type == "IF_curr_exp"
        return self._step.late * current_based

    def _matrices(self, pre: str, post: str, projections: list[Projection]) -> dict[int, FloatArray]:
        """Return the weights by delay (steps)."""
        n_post, n_pre = (self._network.populations[label].size for label in (post, pre))
        if n_post * n_pre > _MOST_WEIGHTS:
            raise NetworkError(
                f"save_nir: NIR stores all weights between two populations, and '{pre}' to '{post}' would be "
                f"{n_post} x {n_pre}; keep the network with save_network"
            )
        found: dict[int, FloatArray] = {}
        for one in projections:
            steps = one.delay_ms / self._step.h_ms
            whole = np.rint(steps).astype(int)
            if one.size and np.abs(steps - whole).max() > 1e-6:
                worst = float(one.delay_ms[np.argmax(np.abs(steps - whole))])
                raise NetworkError(
                    f"projection '{one.label}': a delay of {worst:g} ms is not a multiple of the step, "
                    f"{self._step.h_ms:g} ms"
                )
            for delay in np.unique(whole):
                chosen = whole == delay
                matrix = found.setdefault(int(delay), np.zeros((n_post, n_pre)))
                ends = one.post_index[chosen], one.pre_index[chosen]
                np.add.at(matrix, ends, one.weight[chosen])
        return found

    def _linear(self, pre: str, post: str, weights: FloatArray, bias: FloatArray, delay_steps: int) -> None:
        """Add the nodes between two populations."""
        matrix = self._nir.Affine(weights, bias) if bias.any() else self._nir.Linear(weights)
        last = first = self._named(f"{pre} to {post}")
        self._nodes[first] = matrix
        self._edges.append((pre, first))
        if delay_steps:
            last = self._named(f"{pre} to {post}, delay")
            delays = np.full(len(weights), delay_steps * self._step.dt_s)
            self._nodes[last] = self._nir.Delay(delays)
            self._edges.append((first, last))
        self._edges.append((last, post))

    def _end(self) -> None:
        """Add an output after each population that excites no other, or after all."""
        onward = {one.pre for one in self._network.projections if one.pre != one.post}
        for label in [label for label in self._refractory if label not in onward] or self._refractory:
            name = self._named(f"{label}, output")
            self._nodes[name] = self._nir.Output(np.array([self._network.populations[label].size]))
            self._edges.append((label, name))

    def _named(self, name: str) -> str:
        """Return a name that no node has."""
        number, free = 1, name
        while free in self._nodes or free in self._network.populations:
            number += 1
            free = f"{name} {number}"
        return free
