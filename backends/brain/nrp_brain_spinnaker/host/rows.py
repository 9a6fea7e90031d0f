"""Convert projections to synapses ordered by source neuron."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.ring import Rows, WeightArray
from nrp_core._support.arrays import IndexArray, IntArray


@dataclass(frozen=True, slots=True)
class Synapses:
    """The synapses of several projections, ordered by source neuron.

    Args:
        order: index of each synapse in the concatenated projections.
        pre: global ids, ascending.
        line, weight, delay: as in :class:`~nrp_brain_spinnaker.machine.ring.Rows`.
    """

    order: IntArray
    pre: IndexArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray

    def rows(self, n_sources: int) -> Rows:
        """Return them with the index of the first synapse of each of ``n_sources`` global ids."""
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
