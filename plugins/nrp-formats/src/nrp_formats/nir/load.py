"""Reads a file as a network, or builds it in a PyNN simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np

from nrp_core.brain import FloatArray, Network, builder
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.picking import Selection, with_views
from nrp_core.utilities import Named, checks_arguments
from nrp_formats.nir.graded import currents
from nrp_formats.nir.graph import Graph, lags_of, read_graph, returning
from nrp_formats.nir.linear import NEURONS, Signal, Signals, emitting
from nrp_formats.nir.neurons import Cells, Method, Step, cells_of, late_of, relays

Reset = Literal["value", "subtract", "subtract_next"]
DOWN: Final = "step_down"
KICK: Final = "kick"
_DELTA: Final = "dv/dt = (v_rest - v)/tau_m + i_offset/cm : mV (unless refractory)"
_EXPONENTIAL: Final = """
dv/dt = (v_rest - v)/tau_m + (isyn_exc + i_offset)/cm : mV (unless refractory)
disyn_exc/dt = -isyn_exc/tau_syn_E : nA
"""
_EQUATIONS: Final = {"IF_curr_delta": (_DELTA, "v"), "IF_curr_exp": (_EXPONENTIAL, "isyn_exc")}
_UNITS: Final = {
    "v_rest": "mV", "v_reset": "mV", "v_thresh": "mV", DOWN: "mV", "tau_m": "ms", "tau_refrac": "ms",
    "tau_syn_E": "ms", "cm": "nF", "i_offset": "nA", KICK: "",
}  # fmt: skip


def step_down(cells: Cells, threshold: FloatArray, h_ms: float, reset: Reset) -> FloatArray:
    """Return the voltage that cells subtract when they fire.

    Args:
        cells: the cells.
        threshold: their thresholds in the file.
        h_ms: the step of the network.
        reset: ``subtract_next`` if the threshold is subtracted after the decay of the next step, as in
            snnTorch, else before it.
    """
    if reset == "subtract":
        return threshold
    return np.asarray(threshold * np.exp(h_ms / cells.parameters["tau_m"]))


def in_equations(sim: Any, cells: Cells, down: FloatArray | None) -> Any:
    """Return a cell type in equations, with its parameters.

    Args:
        sim: the simulator.
        cells: the cells.
        down: the voltage that a cell subtracts when it fires, or None if it takes its reset value.
    """
    equations, target = _EQUATIONS[cells.cell_type]
    used = [name for name in _UNITS if name in equations]
    values = {name: cells.parameters[name] for name in (*used, "v_thresh", "tau_refrac")}
    receptors = dict.fromkeys(("excitatory", "inhibitory"), f"{target} += weight")
    values |= {"v_reset": cells.parameters["v_reset"]} if down is None else {DOWN: down}
    reset, refractory = "v = v_reset" if down is None else f"v -= {DOWN}", "tau_refrac"
    if cells.kick is not None:  # an input that arrives as the period ends is lost too
        values |= {KICK: cells.kick, "tau_refrac": values["tau_refrac"] - sim.get_time_step() / 2}
        receptors |= {KICK: f"v += {KICK}*weight"}
        equations, refractory = f"{equations}\ndfree/dt = 0 : ms", "t < free"
        reset = f"{reset}; free = t + tau_refrac"
    kind = sim.EquationCell(
        equations, threshold="v >= v_thresh", reset=reset, refractory=refractory, receptors=receptors,
        parameters={name: f"{name != 'v_reset':d} {_UNITS[name]}" for name in values},
        name=f"{cells.cell_type} in steps",
    )  # fmt: skip
    return kind(**{name: value.tolist() for name, value in values.items()})


_STEP_MS = 1.0


@checks_arguments()
def read_nir(
    path: Path | str,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,
) -> Network:
    """Read a trained network; its inputs are cells that devices drive, and one of its steps takes 1 ms.

    :func:`load_nir` in a brain script has all options.

    Args:
        path: the file.
        populations: additional named selections of its neurons.
        seed: has no effect, since the file holds no random values to draw.

    Raises:
        NetworkError: the file cannot be read, or has a node that cannot be built.
        NeuronSelectionError: ``populations`` reaches outside the network.
    """
    sim = builder(seed)
    sim.setup(timestep=_STEP_MS)
    load_nir(sim, path, inputs="cells")
    return with_views(sim.network(), populations or {})


def _without_early_biases(cells: Cells) -> Cells:
    """Return cells; those that a bias would make fire before the lag of their node are at rest, without it.

    A state that ends at rest after as many steps is above the threshold, or too far from it for a number.
    """
    if not cells.initial:
        return cells
    is_early = ~(cells.initial["v"] < cells.parameters["v_thresh"]) | ~np.isfinite(cells.initial["v"])
    initial = {**cells.initial, "v": np.where(is_early, cells.parameters["v_rest"], cells.initial["v"])}
    if "isyn_exc" in initial:
        initial["isyn_exc"] = np.where(is_early, 0.0, initial["isyn_exc"])
    offset = np.where(is_early, 0.0, cells.parameters["i_offset"])
    return replace(cells, initial=initial, parameters={**cells.parameters, "i_offset": offset})


Inputs = Literal["sources", "cells"]
DT_S: Final = 1e-4
"""The step that most frameworks assume when they write a file."""
_MOST_REFRACTORY: Final = 10**6
_CURRENTS: Final = frozenset({"CubaLIF", "CubaLI"})
_RESETTING: Final = frozenset({"LIF", "IF", "CubaLIF"})


@checks_arguments("method", "inputs", "reset", "refractory", "dt")
def load_nir(
    sim: Any,
    path: Path | str,
    *,
    dt: float | None = None,
    method: Method | None = None,
    inputs: Inputs = "sources",
    refractory: int | None = None,
    reset: Reset | None = None,
) -> dict[str, Any]:
    """Build the network of a file, at the time step of ``setup``.

    Args:
        sim: the simulator; one step of the network takes its time step.
        path: the file.
        dt: s; the length of a step in the time of the file, by default the ``dt`` in its metadata, or 0.1 ms.
        method: ``euler`` if states decay by ``1 - dt/tau`` in a step and currents act in the step in which
            they change, as in snnTorch; ``exact`` for the equations of NIR; ``held`` for these where an input
            to an LIF or LI node lasts for a step, as in Sinabs. By default the ``method`` in the metadata, or
            ``exact``.
        refractory: steps after a spike in which a voltage stays at its reset value; the equations have none.
            By default the ``refractory`` in the metadata, or 0.
        reset: ``value`` if a cell that fires takes its ``v_reset``, which all files contain; ``subtract`` if
            its threshold is subtracted, ``subtract_next`` if that is in the next step, after the decay, as in
            snnTorch. By default the ``reset`` in the metadata, or ``value``.
        inputs: ``sources`` for spike sources, or ``cells`` that fire when a device sends them a weight of 1.

    Returns:
        The populations by the names of their nodes. The voltage of a graded node is its output. The number of
        steps by which the spikes of a population are late is ``lag`` in its annotations.

    Raises:
        NetworkError: the file cannot be read, or has a node that cannot be built.
    """
    graph = read_graph(path)
    method = graph.metadata.get("method", "exact") if method is None else method
    refractory = graph.metadata.get("refractory", 0) if refractory is None else refractory
    reset = graph.metadata.get("reset", "value") if reset is None else reset
    choices: Any = (("method", method, Method), ("inputs", inputs, Inputs), ("reset", reset, Reset))
    for name, value, kind in choices:
        valid = get_args(kind)
        if value not in valid:
            raise NetworkError(f"load_nir: {name} is '{value}'{did_you_mean(str(value), valid)}")
    length = graph.metadata.get("dt", DT_S) if dt is None else dt
    try:
        dt_s = float(length)
    except (TypeError, ValueError):
        raise NetworkError(f"load_nir: dt is {length!r}; it must be a number of seconds") from None
    if not 0.0 < dt_s < np.inf:
        raise NetworkError(f"load_nir: dt is {dt_s:g} s; it must be more than 0, and finite")
    if refractory not in range(_MOST_REFRACTORY):
        raise NetworkError(f"load_nir: refractory is {refractory}; it must be a number of steps, 0 or more")
    step = Step(dt_s, float(sim.get_time_step()), method, int(refractory))
    if reset == "value" and graph.metadata.get("reset_mechanism") == "subtract":
        sim.state.remark(
            "the metadata of the file say that cells subtract their threshold, and here they go to v_reset: "
            "is load_nir(..., reset='subtract_next') meant, as in snnTorch, or 'subtract'?"
        )
    return _Loader(sim, graph, step, inputs, reset).load()


class _Loader:
    def __init__(self, sim: Any, graph: Graph, step: Step, inputs: Inputs, reset: Reset) -> None:
        self._sim, self._graph, self._step, self._inputs = sim, graph, step, inputs
        self._reset = reset
        kinds = {name: type(node).__name__ for name, node in graph.nodes.items()}
        own = {name for name, kind in kinds.items() if kind == "Input" and not graph.before[name]}
        self._order = [name for name, kind in kinds.items() if name in own or kind in NEURONS]
        self._kinds = kinds
        self._shapes = emitting(graph, set(self._order))
        signals = Signals(graph, self._shapes)
        into = {name: signals.into(name) for name in self._order if name not in own}
        self._signals, self._currents = currents(graph, self._shapes, into, step.dt_s)

    def load(self) -> dict[str, Any]:
        """Build all populations and projections; return the populations by name."""
        edges = [(key[0], end) for end, signal in self._signals.items() for key in signal.parts]
        self._back = returning(self._order, edges)
        self._kicked = self._in_short_loops()
        late = {name: self._late(name) for name in self._order}
        self._lags = lags_of(self._order, self._shortest(), late)
        cells = {name: self._cells(name) for name in self._order}
        populations = {name: self._population(name, cells[name]) for name in self._order}
        for end, signal in self._signals.items():
            for (start, delay_s), matrix in signal.parts.items():
                self._connect(populations, start, end, delay_s, matrix, cells[end])
        return Named(populations, "population", "the file")

    def _in_short_loops(self) -> set[str]:
        """Return the nodes whose spikes return in one step, so that an input must act at its arrival."""
        if not self._step.late:
            return set()
        ends = {
            name
            for end, signal in self._signals.items()
            for start, delay_s in signal.parts
            if (start, end) in self._back and not delay_s
            for name in (start, end)
        }
        return {name for name in ends if self._kinds[name] in _RESETTING and self._has_current(name)}

    def _has_current(self, name: str) -> bool:
        return self._kinds[name] in _CURRENTS or name in self._currents

    def _late(self, name: str) -> int:
        kind = self._kinds[name]
        if name in self._kicked or not self._has_current(name):
            return 0
        return late_of(self._step, follows=kind == "Threshold")

    def _shortest(self) -> Mapping[tuple[str, str], int]:
        shortest: dict[tuple[str, str], int] = {}
        for end, signal in self._signals.items():
            for start, delay_s in signal.parts:
                if (start, end) not in self._back:
                    delay = self._steps(end, delay_s)
                    shortest[start, end] = min(delay, shortest.get((start, end), delay))
        return shortest

    def _steps(self, name: str, delay_s: float) -> int:
        steps = round(delay_s / self._step.dt_s)
        if abs(steps * self._step.dt_s - delay_s) > 1e-6 * self._step.dt_s:
            raise self._graph.error(
                name,
                f"a delay of {delay_s:g} s on the way to it is not a multiple of the step, "
                f"{self._step.dt_s:g} s",
            )
        return steps

    def _cells(self, name: str) -> Cells:
        shape = self._shapes[name]
        if self._kinds[name] == "Input":
            return relays(int(np.prod(shape)), self._step)
        signal: Signal = self._signals[name]
        count = int(np.prod(shape))
        if (given := int(np.prod(signal.shape))) != count:
            raise self._graph.error(name, f"it has {count} cells, and {given} values lead to it")
        bias = np.broadcast_to(signal.bias, count).astype(float)
        try:
            node, current = self._graph.nodes[name], self._currents.get(name)
            kicked = name in self._kicked
            return cells_of(node, shape, bias, self._step, self._lags[name], current, kicked=kicked)
        except ValueError as error:
            raise self._graph.error(name, str(error)) from error

    def _population(self, name: str, cells: Cells) -> Any:
        sim, n = self._sim, int(np.prod(self._shapes[name]))
        if self._kinds[name] == "Input" and self._inputs == "sources":
            population = sim.Population(n, sim.SpikeSourceArray(), label=name)
        else:
            started = _without_early_biases(cells)
            population = sim.Population(n, self._cell_type(name, started), label=name)
            if started.initial:
                population.initialize(**started.initial)
            self._begin_biases(population, cells, started)
        population.annotate(lag=self._lags[name], kind=self._kinds[name])
        return population

    def _cell_type(self, name: str, cells: Cells) -> Any:
        """Return a cell type with its parameters."""
        down = None
        if self._reset != "value" and self._kinds[name] in _RESETTING:
            limits = np.broadcast_to(self._graph.nodes[name].v_threshold, self._shapes[name]).ravel()
            down = step_down(cells, limits.astype(float), self._step.h_ms, self._reset)
        if down is not None or cells.kick is not None:
            return in_equations(self._sim, cells, down)
        values = {key: value.tolist() for key, value in cells.parameters.items()}
        return getattr(self._sim, cells.cell_type)(**values)

    def _begin_biases(self, population: Any, cells: Cells, started: Cells) -> None:
        """Let the biases begin, at the lag of the node, that do not act from the start."""
        sim, h_ms, lag = self._sim, self._step.h_ms, self._lags[population.label]
        missing = cells.parameters["i_offset"] - started.parameters["i_offset"]
        for amplitude in np.unique(missing[missing != 0.0]):
            source = sim.StepCurrentSource(times=[lag * h_ms], amplitudes=[amplitude])
            population[np.flatnonzero(missing == amplitude)].inject(source)
        if "isyn_exc" not in cells.initial:
            return
        faded = np.exp(-lag * h_ms / cells.parameters["tau_syn_E"])
        current = (cells.initial["isyn_exc"] - started.initial["isyn_exc"]) * faded
        signs = {"excitatory": current > 0.0, "inhibitory": current < 0.0}
        if current.any():
            once = sim.SpikeSourceArray(spike_times=[h_ms])
            start = sim.Population(1, once, label=f"start of the biases of {population.label}")
        for receptor, chosen in signs.items():
            if chosen.any():
                each = [(0, cell, current[cell], (lag - 1) * h_ms) for cell in np.flatnonzero(chosen)]
                sim.Projection(
                    start,
                    population,
                    sim.FromListConnector(each),
                    sim.StaticSynapse(),
                    receptor_type=receptor,
                )

    def _connect(
        self, populations: dict[str, Any], start: str, end: str, delay_s: float, matrix: Any, cells: Cells
    ) -> None:
        found = matrix.tocoo()
        weights = found.data * cells.per_weight[found.coords[0]]
        steps = self._steps(end, delay_s) + ((start, end) in self._back) + self._lags[end] - self._lags[start]
        delay_ms = max(steps - cells.late, 1) * self._step.h_ms
        if steps - cells.late < 1:
            more = 1 + cells.late - steps
            self._sim.state.remark(
                f"the feedback from '{start}' to '{end}' takes longer than in the file, by {more} steps"
            )
        receptors = {"excitatory": weights > 0, "inhibitory": weights < 0}
        if cells.kick is not None:
            receptors |= {KICK: weights != 0}
        for receptor, chosen in receptors.items():
            if chosen.any():
                rows = [found.coords[1][chosen], found.coords[0][chosen], weights[chosen]]
                each = np.column_stack([*rows, np.full(int(chosen.sum()), delay_ms)])
                connector = self._sim.FromListConnector(each)
                label = f"{start}→{end} ({receptor}, {delay_ms:g} ms)"
                self._sim.Projection(
                    populations[start], populations[end], connector, self._sim.StaticSynapse(),
                    receptor_type=receptor, label=label,
                )  # fmt: skip
