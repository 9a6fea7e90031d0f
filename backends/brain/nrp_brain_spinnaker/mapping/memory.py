"""The memory that cores need: synaptic rows and parameters in SDRAM, ring buffers and state in DTCM.

The size of a row block is that of the software; the other needs of a core were fitted to its allocations. The
error is 1 % for lists of synapses and about 10 % for random connectors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_brain_spinnaker.host.delays import RECEPTORS, bits_for, slots_available, slots_used, stages
from nrp_brain_spinnaker.host.distributions import binomial_quantile
from nrp_brain_spinnaker.host.weights import connection_probability
from nrp_brain_spinnaker.host.wiring import Wires

_HEADER_WORDS = 3
_BASE_BYTES, _NEURON_BYTES, _FURTHER_PROJECTION_BYTES, _CONDUCTANCE_BYTES = 1300, 524.13, 5600, 8
_STATE_BYTES = 64
_ARRAY_BASE_BYTES, _POISSON_BASE_BYTES, _POISSON_BYTES, _EXTENSION_BYTES = 512, 548, 74, 520


def source_bytes(cell_type: str, n: int) -> int:
    """Return the fixed SDRAM of a core with ``n`` sources or entries of a delay extension."""
    if cell_type == "SpikeSourceArray":
        return _ARRAY_BASE_BYTES + spike_bytes_per_tick(n)
    return _POISSON_BASE_BYTES + _POISSON_BYTES * n if cell_type == "SpikeSourcePoisson" else _EXTENSION_BYTES


def spike_bytes_per_tick(n: int) -> int:
    """Return the size of one tick's spikes of ``n`` array sources, bytes: keys in packets of 64."""
    return 4 * n + 6 * -(-n // 64)


def longest_row(part: Wires, per_core: int) -> int:
    """Return the largest probable number of synapses from one neuron into one core, or the room for them."""
    rewiring = part.projection.rewiring
    room = 0 if rewiring is None else rewiring.s_max
    n_post = part.post_last - part.post_first
    probability = connection_probability(part.projection)
    if probability is not None:
        n_probable = binomial_quantile(min(n_post, per_core), probability, 1 - 1e-4 / (part.n_pre * n_post))
        return max(room, n_probable)
    slices = -(-n_post // per_core)
    places = part.projection.pre_index.astype(np.int64) * slices + part.projection.post_index // per_core
    return int(np.bincount(places).max(initial=room))


def neuron_core_bytes(wires: Sequence[Wires], n: int, per_core: int) -> int:
    """Return the SDRAM of a core of a population.

    Args:
        wires: the projections onto the population.
        n: number of its neurons on a core.
        per_core: maximum number of neurons on a core.
    """
    matrix = 0
    for part in wires:
        rows = part.n_pre * max(1, stages(n, int(part.ticks.max())))  # a delay extension sends once per stage
        block = rows * (_HEADER_WORDS + longest_row(part, per_core)) * 4
        matrix += -(-block // 16) * 16
    conductance = any(part.model.is_conductance_based for part in wires)
    further = max(len(wires) - 1, 0) * _FURTHER_PROJECTION_BYTES
    own = _BASE_BYTES + round((_NEURON_BYTES + conductance * _CONDUCTANCE_BYTES) * n)
    return matrix + own + further


def dtcm_bytes(wires: Sequence[Wires], n: int, per_core: int) -> int:
    """Return the DTCM of a neuron core: ring buffer, state, and two rows in transfer."""
    longest = max((int(part.ticks.max()) for part in wires), default=0)
    slots = slots_used(n, min(longest, slots_available(n)))
    ring = slots * RECEPTORS * (1 << bits_for(n)) * 2
    rows = max((longest_row(part, per_core) for part in wires), default=0)
    return ring + _STATE_BYTES * n + 2 * 4 * (_HEADER_WORDS + rows)
