"""From projections to synapses ordered by the neuron they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.cells import Grid
from nrp_brain_spinnaker.host.conversion import to_accum
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.ring import Rows, WeightArray
from nrp_brain_spinnaker.machine.tsodyks_markram import WHOLE, TsodyksRows
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core.brain.network.data import Projection
from nrp_core.errors import NetworkError


@dataclass(frozen=True, slots=True)
class Synapses:
    """The synapses of several projections, ordered by the neuron they come from.

    Args:
        order: where each synapse stood when the projections lay one after another.
        pre: global ids, ascending.
        line, weight, delay: as in :class:`~nrp_brain_spinnaker.machine.ring.Rows`.
    """

    order: IntArray
    pre: IndexArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray

    def rows(self, n_sources: int) -> Rows:
        """Return them with the first synapse of each of ``n_sources`` global ids."""
        start = np.zeros(n_sources + 1, np.int64)
        np.cumsum(np.bincount(self.pre, minlength=n_sources), out=start[1:])
        return Rows(start, self.line, self.weight, self.delay)


def collect(wires: Sequence[Wires], n: int) -> Synapses:
    """Order the synapses of projections onto the lines of ``n`` neurons; a stable order."""
    no_index, no_weight = np.empty(0, np.int32), np.empty(0, np.uint16)
    pre = np.concatenate([no_index, *(part.projection.pre_index + part.pre_first for part in wires)])
    line = np.concatenate([no_index, *(_lines(part, n) for part in wires)])
    weight = np.concatenate([no_weight, *(part.raw for part in wires)])
    delay = np.concatenate([no_weight, *(_delays(part) for part in wires)])
    order = np.argsort(pre, kind="stable")
    return Synapses(
        order, pre[order].astype(np.int32), line[order].astype(np.int32), weight[order], delay[order]
    )


def _delays(part: Wires) -> WeightArray:
    return np.broadcast_to(part.ticks.astype(np.uint16), part.projection.pre_index.shape)


def _lines(part: Wires, n: int) -> IndexArray:
    return part.projection.post_index + np.int32(part.receptor * n + part.post_first)


def load_static(wires: Sequence[Wires], n_sources: int, n: int) -> Rows:
    """Return the static synapses of a network with ``n_sources`` global ids and ``n`` simulated neurons."""
    return collect(wires, n).rows(n_sources)


def load_dynamic(wires: Sequence[Wires], n_sources: int, tau_syn: IntArray, grid: Grid) -> TsodyksRows:
    """Return the Tsodyks-Markram synapses, fully recovered.

    Args:
        wires: the projections.
        n_sources: number of global ids.
        tau_syn: time constant of the synapse behind each line, s16.15, shape ``(2 n,)``.
        grid: the time step.
    """
    synapses = collect(wires, tau_syn.size // 2)
    parameters = np.concatenate(
        [np.empty((3, 0), np.int64), *(_parameters(part.projection) for part in wires)], axis=1
    )
    parameters = np.vstack([parameters[:, synapses.order], tau_syn[synapses.line]])
    state = np.zeros((4, synapses.order.size), np.int64)
    return TsodyksRows(*synapses.rows(n_sources), parameters, state, grid.step)


def _parameters(projection: Projection) -> IntArray:
    given = projection.synapse_parameters
    try:
        times = [to_accum(given[name], name) for name in ("tau_rec", "tau_facil")]
    except ValueError as error:
        raise NetworkError(f"projection '{projection.label}': {error}") from None
    return np.stack([np.rint(given["U"] * WHOLE).astype(np.int64), *times])
