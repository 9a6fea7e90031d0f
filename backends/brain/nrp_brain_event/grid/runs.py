"""Convert cells to runs: the coefficients of neurons' updates by a step, and their initial state."""

from __future__ import annotations

from math import e, prod
from typing import Any, Final

import numpy as np

from nrp_brain_event.grid.records import CONDUCTANCE, CURRENT, CURVED, EQUATIONS, JUMP, N_STATE, Run, S, V, X
from nrp_brain_event.records import ALPHA, FROZEN, LINEAR, Array
from nrp_brain_event.records import CONDUCTANCE as CONDUCTANCE_MEMBRANE
from nrp_brain_event.records import EQUATIONS as OWN_EQUATIONS
from nrp_brain_event.records import JUMP as JUMP_SYNAPSE
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.filters import driven

_DECIDING: Final = (
    "membrane", "synapse", "v_rest", "v_reset", "v_thresh", "tau_m", "cm", "tau_refrac", "tau_syn",
    "e_rev_E", "e_rev_I",
)  # fmt: skip
"""Fields that are equal for all cells of a run."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def kind_of(cell: Any) -> int:
    """Return the kind of update of a ``Cell``."""
    if cell["membrane"] == LINEAR:
        return JUMP if cell["synapse"] == JUMP_SYNAPSE else CURRENT
    if cell["membrane"] == OWN_EQUATIONS:
        return EQUATIONS
    return CONDUCTANCE if cell["membrane"] == CONDUCTANCE_MEMBRANE else CURVED


def line_of(cell: Any, receptor: int) -> int:
    """Return the row of the state on which spikes act that arrive at a receptor of a ``Cell``."""
    kind = kind_of(cell)
    if kind == JUMP:
        return X
    return receptor + (S if kind != CURVED and cell["synapse"] == ALPHA else X)


def load_runs(cells: Array, h: float) -> Array:
    """Return the ``Run`` records of cells, for steps of h ms."""
    columns = [cells[name].reshape(len(cells), prod(cells[name].shape[1:])) for name in _DECIDING]
    deciding = np.concatenate(columns, axis=1)
    own = ~np.isin(cells["membrane"], (LINEAR, CONDUCTANCE_MEMBRANE))
    deciding[own, 1:] = 0.0  # integrated one by one, or by a kernel of their population
    begins = np.append(True, (deciding[1:] != deciding[:-1]).any(axis=1))[: len(cells)]
    firsts = np.flatnonzero(begins)
    runs = np.zeros(len(firsts), Run.dtype())
    runs["first"], runs["last"] = firsts, np.append(firsts[1:], len(cells))
    for run in runs:
        cell = cells[run["first"]]
        run["kind"] = kind_of(cell)
        if run["kind"] not in (CURVED, EQUATIONS):
            _derive(run, cell, h)
    return runs


def load_state(cells: Array) -> FloatArray:
    """Return the initial state of cells."""
    state = np.zeros((N_STATE, len(cells)))
    held = np.isin(cells["membrane"], (LINEAR, CONDUCTANCE_MEMBRANE))
    state[V] = np.where(held, cells["path"][:, 0, 0] - cells["v_rest"], 0.0)
    state[X : X + 2] = np.where(held, cells["x"].T, 0.0)
    return state


def input_lines(runs: Array, state: FloatArray) -> IntArray:
    """Return the index into the flattened state on which inputs act, for both receptors and each row."""
    rows, lengths = np.arange(state.shape[1]), runs["last"] - runs["first"]
    jumps = runs["kind"] == JUMP
    grown = ((runs["kind"] == CURRENT) | (runs["kind"] == CONDUCTANCE)) & (runs["alpha"] == 1)
    lines = [np.where(jumps, X, np.where(grown, S, X) + receptor) for receptor in range(2)]
    return np.stack([np.repeat(line, lengths) * len(rows) + rows for line in lines])


def _derive(run: Any, cell: Any, h: float) -> None:
    run["alpha"] = cell["synapse"] == ALPHA
    run["v_rest"] = cell["v_rest"]
    run["reset"], run["threshold"] = cell["v_reset"] - cell["v_rest"], cell["v_thresh"] - cell["v_rest"]
    run["refractory"] = np.ceil(cell["tau_refrac"] / h - 1e-6)
    run["frozen"] = cell["synapse"] == FROZEN
    if run["frozen"]:  # as in Brian2, the step in which the period ends counts
        run["refractory"] = max(run["refractory"] - 1, 0)
    run["reversal"] = cell["e_rev_E"] - cell["v_rest"], cell["e_rev_I"] - cell["v_rest"]
    run["kept"] = np.exp(-h / cell["tau_syn"])
    run["grown"] = e * h / cell["tau_syn"]
    if run["kind"] == CONDUCTANCE:
        run["leak"], run["gain"] = h / cell["tau_m"], h / cell["cm"]
        _derive_moments(run, cell, h)
        return
    run["leak"] = np.exp(-h / cell["tau_m"])
    run["gain"] = -np.expm1(-h / cell["tau_m"]) * cell["tau_m"] / cell["cm"]
    for k, tau in enumerate(cell["tau_syn"].tolist()):
        leak, kept, gap = float(run["leak"]), float(run["kept"][k]), 1.0 / tau - 1.0 / float(cell["tau_m"])
        unit = float(cell["tau_m"] if run["frozen"] else cell["cm"])
        run["x_effect"][k] = driven(h, leak, kept, gap, 1.0, 0.0) / unit
        run["s_effect"][k] = driven(h, leak, kept, gap, 0.0, e / tau) / unit


def _derive_moments(run: Any, cell: Any, h: float) -> None:
    """Integrate the course of both synapses over a step by Gauss-Legendre quadrature."""
    u, weights = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS * run["gain"]
    for k, tau in enumerate(cell["tau_syn"].tolist()):
        x = weights * np.exp(-u * h / tau)
        s = x * u * run["grown"][k]
        run["x_effect"][k], run["s_effect"][k] = x.sum(), s.sum()
        run["x_moment"][k], run["s_moment"][k] = (x * (u - 0.5)).sum(), (s * (u - 0.5)).sum()
