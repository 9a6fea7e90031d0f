"""Synapses with depression and facilitation, updated at each spike.

Not part of the machine's software. The rule is that of Tsodyks, Uziel & Markram (2000, J. Neurosci. 20:RC50):
resources are recovered (x), active (y, decaying with the synapse) or inactive (z); ``u`` is the share used by
a spike. Fractions are kept in units of 2**-31, in which 1 is a number, and products floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_spinnaker.host.cells import Layout
from nrp_brain_spinnaker.host.wiring import Wires, collect
from nrp_brain_spinnaker.machine.fixed_point import exp_fraction, to_accum
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring, WeightArray, add_entry
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.errors import NetworkError
from nrp_core.network.data import Projection

WHOLE: Final = 1 << 31
"""The fraction 1."""

USE, TAU_REC, TAU_FACIL, TAU_SYN = range(4)
LAST_TICK, USED, ACTIVE, INACTIVE = range(4)


class TsodyksRows(NamedTuple):
    """Tsodyks-Markram synapses, ordered by source neuron.

    Args:
        start, line, weight, delay: as for static synapses.
        parameters: share used by a spike (a fraction), time constants (s16.15), shape ``(4, n_synapses)``.
        state: last tick; fractions used, active, inactive; shape ``(4, n_synapses)``.
        step: length of a tick, ms, s16.15.
    """

    start: IntArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray
    parameters: IntArray
    state: IntArray
    step: int


@jit
def deliver_dynamic(rows: TsodyksRows, ring: Ring, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) in ``tick`` through its Tsodyks-Markram synapses."""
    mask = ring.slots.shape[0] - 1
    for k in range(rows.start[neuron], rows.start[neuron + 1]):
        released = _released(rows.parameters, rows.state, k, tick, rows.step)
        slot = (tick + np.int64(rows.delay[k])) & mask
        add_entry(ring, slot, rows.line[k], (np.int64(rows.weight[k]) * released) >> 31)


@jit
def _released(parameters: IntArray, state: IntArray, k: int, tick: int, step: int) -> int:
    """Advance synapse ``k`` to ``tick`` and return the fraction of its weight that a spike releases."""
    elapsed = (tick - state[LAST_TICK, k]) * step
    tau_rec, tau_syn = parameters[TAU_REC, k], parameters[TAU_SYN, k]
    recovering, ending = _decay(elapsed, tau_rec), _decay(elapsed, tau_syn)
    active = (state[ACTIVE, k] * ending) >> 31
    inactive = ((state[INACTIVE, k] * recovering) >> 31) + _inactivated(
        state[ACTIVE, k], elapsed, tau_rec, tau_syn, recovering, ending
    )
    recovered = min(max(WHOLE - active - inactive, 0), WHOLE)
    used = (state[USED, k] * _decay(elapsed, parameters[TAU_FACIL, k])) >> 31
    used += (parameters[USE, k] * (WHOLE - used)) >> 31
    released = (used * recovered) >> 31
    state[LAST_TICK, k], state[USED, k] = tick, used
    state[ACTIVE, k], state[INACTIVE, k] = active + released, inactive
    return int(released)


@jit
def _inactivated(active: int, elapsed: int, tau_rec: int, tau_syn: int, recovering: int, ending: int) -> int:
    """Return the fraction of active resources that is inactive after ``elapsed``."""
    apart = tau_syn - tau_rec
    if abs(apart) > tau_rec >> 10:
        return ((active * (ending - recovering)) >> 31) * tau_rec // apart
    if tau_rec == 0 or recovering == 0:
        return 0
    return ((active * recovering) >> 31) * elapsed // tau_rec


@jit
def _decay(elapsed: int, tau: int) -> int:
    """Return exp(-elapsed / tau) as a fraction; 0 for ``tau`` 0."""
    if tau <= 0:
        return 0
    n = (elapsed << 15) // tau
    return exp_fraction(-n) >> 1 if n > 0 else WHOLE


def load_dynamic(wires: Sequence[Wires], layout: Layout) -> TsodyksRows:
    """Return the Tsodyks-Markram synapses of projections, fully recovered.

    Raises:
        NetworkError: a time constant does not fit the machine.
    """
    synapses = collect(wires, layout.n)
    parameters = np.concatenate(
        [np.empty((3, 0), np.int64), *(_parameters(part.projection) for part in wires)], axis=1
    )
    parameters = np.vstack([parameters[:, synapses.order], layout.tau_syn[synapses.line]])
    state = np.zeros((4, synapses.order.size), np.int64)
    return TsodyksRows(*synapses.rows(layout.n_sources), parameters, state, layout.grid.step)


def _parameters(projection: Projection) -> IntArray:
    given = projection.synapse_parameters
    try:
        times = [to_accum(given[name], name) for name in ("tau_rec", "tau_facil")]
    except ValueError as error:
        raise NetworkError(f"projection '{projection.label}': {error}") from None
    return np.stack([np.rint(given["U"] * WHOLE).astype(np.int64), *times])


def set_tau_syn(rows: TsodyksRows, tau_syn: IntArray, first: int, last: int) -> None:
    """Take over the time constants of synapses onto neurons ``first`` to ``last - 1``.

    Args:
        rows: the synapses.
        tau_syn: time constant of the synapse behind each line, s16.15, shape ``(2 n,)``.
        first: the first neuron.
        last: the one after the last neuron.
    """
    neurons = rows.line % (tau_syn.size // 2)
    ours = (neurons >= first) & (neurons < last)
    rows.parameters[TAU_SYN, ours] = tau_syn[rows.line[ours]]
