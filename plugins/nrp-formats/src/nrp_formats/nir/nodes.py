"""PyNN's cells as nodes of neurons: the inverse of :mod:`nrp_formats.nir.neurons`.

Voltages are those above rest, so that ``v_leak`` is 0 as frameworks expect. A mV or nA is a unit of the file.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Population
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
    kept = np.exp(-step.h_ms / given["tau_m"])
    tau = step.tau_s(given["tau_m"])
    rise = (1.0 - kept) * given["tau_m"] / given["cm"]  # mV in a step by 1 nA
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
