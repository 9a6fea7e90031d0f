"""The synapses of a network as tables of the engine, checked."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt
from nrp_core.brain.network import TSODYKS_MARKRAM, FloatArray, IntArray, Network, Projection
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import NetworkError

from nrp_brain_event.records import JUMP, SHORT_TERM, Array

_LEAST_DELAY_MS: Final = 1.0 / NS_PER_MS


class Connections(NamedTuple):
    """Synapses sorted by the neuron they come from; see :class:`~nrp_brain_event.records.Engine`.

    Args:
        shortest_delay_ms, longest_delay_ms: the former among synapses between neurons that are not
            sources: a source's spikes are known before a window begins.
    """

    first: IntArray
    target: npt.NDArray[np.int32]
    weight: FloatArray
    delay: FloatArray
    dynamics: npt.NDArray[np.int32]
    short_term: Array
    shortest_delay_ms: float
    longest_delay_ms: float


def load_connections(network: Network, cells: Array, row_of: IntArray) -> Connections:
    """Return the synapses of all projections.

    Raises:
        NetworkError: a delay is too short, or a parameter of short-term plasticity impossible.
    """
    projections = [projection for projection in network.projections if projection.size]
    shortest, longest = _delay_range(network, projections)
    pre = [network.offsets[p.pre] + p.pre_index.astype(np.int64) for p in projections]
    order = np.argsort(_joined(pre, np.int64), kind="stable")
    fan_out = np.bincount(_joined(pre, np.int64), minlength=network.size)
    dynamics, short_term = _load_dynamics(projections, cells, network, row_of)
    return Connections(
        first=np.concatenate([[0], np.cumsum(fan_out)]),
        target=_joined([_targets(p, network, row_of) for p in projections], np.int32)[order],
        weight=_joined([p.weight for p in projections], np.float64)[order],
        delay=_joined([p.delay_ms for p in projections], np.float64)[order],
        dynamics=dynamics[order] if len(short_term) else dynamics[:0],
        short_term=short_term,
        shortest_delay_ms=shortest,
        longest_delay_ms=longest,
    )


def _joined(parts: list[npt.NDArray[np.generic]], dtype: type[np.generic]) -> npt.NDArray[np.generic]:
    return np.concatenate([np.empty(0, dtype), *parts]).astype(dtype)


def _targets(projection: Projection, network: Network, row_of: IntArray) -> IntArray:
    post = network.offsets[projection.post] + projection.post_index.astype(np.int64)
    return 2 * row_of[post] + (projection.receptor == "inhibitory")


def _delay_range(network: Network, projections: list[Projection]) -> tuple[float, float]:
    shortest, longest = 1.0, 0.0
    for projection in projections:
        longest = max(longest, float(projection.delay_ms.max()))
        if network.populations[projection.pre].is_source:
            continue
        delay = float(projection.delay_ms.min())
        if delay < _LEAST_DELAY_MS:
            raise NetworkError(
                f"projection '{projection.label}': a delay of {delay:g} ms between neurons; a spike needs "
                f"at least {_LEAST_DELAY_MS:g} ms from one neuron to another"
            )
        shortest = min(shortest, delay)
    return shortest, longest


def _load_dynamics(
    projections: list[Projection], cells: Array, network: Network, row_of: IntArray
) -> tuple[npt.NDArray[np.int32], Array]:
    """Return for each synapse its row in a table of states or -1, and that table."""
    parts, tables, n = [], [], 0
    for projection in projections:
        if projection.synapse_type == TSODYKS_MARKRAM:
            parts.append(np.arange(n, n + projection.size, dtype=np.int32))
            n += projection.size
            tables.append(_short_term(projection, cells[_targets(projection, network, row_of) >> 1]))
        else:
            parts.append(np.full(projection.size, -1, np.int32))
    return _joined(parts, np.int32), np.concatenate([np.empty(0, SHORT_TERM), *tables])


def _short_term(projection: Projection, targets: Array) -> Array:
    table = np.zeros(projection.size, SHORT_TERM)
    for name, least, most in (("U", 0.0, 1.0), ("tau_rec", 1e-9, np.inf), ("tau_facil", 0.0, np.inf)):
        values = projection.synapse_parameters.get(name)
        if values is None:
            raise NetworkError(f"projection '{projection.label}': tsodyks_markram synapses need '{name}'")
        wrong = ~((values >= least) & (values <= most) & np.isfinite(values))
        if wrong.any():
            value = values[np.flatnonzero(wrong)[0]]
            raise NetworkError(
                f"projection '{projection.label}': {name} must lie in {least:g}..{most:g}, not {value:g}"
            )
        table[name] = values
    receptor = "tau_syn_E" if projection.receptor == "excitatory" else "tau_syn_I"
    table["tau_psc"] = np.where(targets["synapse"] == JUMP, 0.0, targets[receptor])
    return table
