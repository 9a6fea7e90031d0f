"""Graded nodes between layers: an integrator before cells is the synaptic current of these cells.

Its equation is that of a current, and it is linear, so its input may be weighted before it as well as after,
if all integrators onto a cell have one time constant. What it rests at is a constant input of these cells.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy import sparse

from nrp_core.brain import FloatArray
from nrp_formats.nir.graph import Graph
from nrp_formats.nir.linear import Shape, Signal, parameters_of

GRADED: Final = frozenset({"LI", "CubaLI", "I"})
DRIVES: Final = frozenset({"LI", "I"})
TAKES_CURRENT: Final = frozenset({"LIF", "IF", "LI", "I", "Threshold"})
NO_LEAK_STEPS: Final = 2.0**50
"""The time constant of what does not leak, in steps; what a step leaves of it is an exact number."""


@dataclass(frozen=True)
class Current:
    """What a node receives through integrators.

    Args:
        tau_s: the time constant for each cell, in the time of the file.
        bias: its constant part for each cell, which rises with this time constant.
    """

    tau_s: FloatArray
    bias: FloatArray


def currents(
    graph: Graph, shapes: Mapping[str, Shape], signals: Mapping[str, Signal], dt_s: float
) -> tuple[dict[str, Signal], dict[str, Current]]:
    """Return the weighted signals of spiking nodes only, and the currents by the names of nodes.

    Args:
        graph: the graph.
        shapes: of the nodes that emit.
        signals: by the names of the nodes that they reach.
        dt_s: the length of a step in the time of the file.

    Raises:
        NetworkError: a graded node has no such equivalent.
    """
    kinds = {name: type(node).__name__ for name, node in graph.nodes.items()}
    found, made = dict(signals), {}
    for end, signal in signals.items():
        starts = {start for start, _ in signal.parts if kinds[start] in GRADED}
        if starts:
            reason = _reason(graph, end, signal, starts, signals)
            if reason:
                start = min(starts)
                raise graph.error(
                    end, f"its input comes from '{start}' ({kinds[start]}), which does not spike; {reason}"
                )
            found[end], made[end] = _through(graph, shapes, signal, signals, dt_s)
    return found, made


def without_leak(given: dict[str, FloatArray], dt_s: float) -> dict[str, FloatArray]:
    """Return the parameters of a node that integrates as those of one that leaks less than rounding."""
    tau = np.full(len(given["r"]), NO_LEAK_STEPS * dt_s)
    return {"v_leak": np.zeros(len(tau)), **given, "tau": tau, "r": given["r"] * tau}


def _reason(graph: Graph, end: str, signal: Signal, starts: set[str], signals: Mapping[str, Signal]) -> str:
    """Return why graded nodes cannot be the synaptic current of a node; empty if they can."""
    kinds = {name: type(graph.nodes[name]).__name__ for name in (end, *(start for start, _ in signal.parts))}
    if any(kinds[start] not in DRIVES for start in starts):
        return "only nodes LI and I may drive others, since a cell here has one current, and CubaLI is two"
    if kinds[end] not in TAKES_CURRENT:
        return f"such a node may drive {', '.join(sorted(TAKES_CURRENT))}, which have no current of their own"
    if len(starts) < len({start for start, _ in signal.parts}):
        return "and spikes reach it too, which a current of its own would need"
    for start in starts:
        sources = (type(graph.nodes[source]).__name__ for source, _ in signals[start].parts)
        if any(source in GRADED for source in sources):
            return "and it is itself driven by a node that does not, which would be a second current"
        if kinds[start] == "I" and np.any(signals[start].bias):
            return "and its constant input lets it rise without end"
    return ""


def _through(
    graph: Graph, shapes: Mapping[str, Shape], signal: Signal, signals: Mapping[str, Signal], dt_s: float
) -> tuple[Signal, Current]:
    parts: dict[tuple[str, float], Any] = {}
    n = next(iter(signal.parts.values())).shape[0]
    lowest, highest, bias, resting = np.full(n, np.inf), np.zeros(n), np.zeros(n), np.zeros(n)
    for (start, later), after in signal.parts.items():
        given = {
            name: np.broadcast_to(value, shapes[start]).ravel()
            for name, value in parameters_of(graph.nodes[start]).items()
        }
        if "tau" not in given:
            given = without_leak(given, dt_s)
        weights = after.tocoo()
        np.minimum.at(lowest, weights.coords[0], given["tau"][weights.coords[1]])
        np.maximum.at(highest, weights.coords[0], given["tau"][weights.coords[1]])
        scaled = after @ sparse.diags_array(given["r"]).tocsr()
        resting += after @ given["v_leak"]
        arriving = signals[start]
        bias = bias + scaled @ np.broadcast_to(arriving.bias, len(given["r"]))
        for (source, delay), before in arriving.parts.items():
            key = source, delay + later
            parts[key] = parts[key] + scaled @ before if key in parts else scaled @ before
    apart = np.flatnonzero((lowest < highest) & np.isfinite(lowest))
    if apart.size:
        cell, (start, _) = int(apart[0]), next(iter(signal.parts))
        raise graph.error(
            start,
            f"what it drives has one time constant for each cell, and cell {cell} gets input from nodes LI "
            f"with {lowest[cell]:g} s and {_time(highest[cell], dt_s)}",
        )
    tau = np.where(np.isfinite(lowest), lowest, np.nanmax(np.where(np.isfinite(lowest), lowest, np.nan)))
    return Signal(signal.shape, parts, signal.bias + resting), Current(tau, bias)


def _time(tau_s: float, dt_s: float) -> str:
    return f"{tau_s:g} s" if tau_s < NO_LEAK_STEPS * dt_s else "from a node I, which does not leak"
