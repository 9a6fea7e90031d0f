"""The weights of projections over time, sampled only while a client subscribes to them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from nrp_core.brain import Brain, FloatArray
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.network.data import Network, Projection
from nrp_core.recording import RecordEntry, Signal

Add = Callable[[RecordEntry], None]
"""Takes an entry of a signal."""
PERIOD_NS = 100 * NS_PER_MS
"""Minimum simulated time between two samples, for each million synapses."""
MOST_STATIC = 32
"""Static projections are offered as well if a brain has no more: functions may set their weights."""
MOST_SYNAPSES = 64
"""Synapses of a projection with a curve of their own."""
_MOST_SORTED = 20_000
_QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
SUMMARY = ("mean", "smallest", "5 %", "25 %", "median", "75 %", "95 %", "largest")
"""What the numbers of the summary of weights are."""


def weights_topic(projection: str) -> str:
    """Return the topic of the summary of the weights of a projection."""
    return f"/brain/projections/{projection}/weights"


def synapses_topic(projection: str) -> str:
    """Return the topic of the weights of some synapses of a projection."""
    return f"/brain/projections/{projection}/synapses"


def watchable(network: Network) -> Iterator[Projection]:
    """Yield the projections whose weights can be watched."""
    few = len(network.projections) <= MOST_STATIC
    for projection in network.projections:
        if projection.size and (few or projection.is_plastic or projection.rewiring is not None):
            yield projection


def weights_data(network: Network) -> Iterator[dict[str, Any]]:
    """Yield the descriptions of the topics, each with the names of its numbers."""
    for projection in watchable(network):
        unit = network.populations[projection.post].weight_unit(projection.receptor).text
        shared = {"type": "std_msgs/Float64MultiArray", "direction": "out", "unit": unit, "rate_hz": None}
        yield {"name": weights_topic(projection.label), "elements": list(SUMMARY), **shared}
        if projection.rewiring is None:
            names = ["{} to {}".format(*projection.ends(int(at))) for at in chosen(projection.size)]
            yield {"name": synapses_topic(projection.label), "elements": names, **shared}


def chosen(size: int) -> FloatArray:
    """Return the indices of the synapses with a curve: all of a few, else some at equal distances."""
    return np.unique(np.linspace(0, size - 1, min(size, MOST_SYNAPSES)).astype(int))


class ProjectionWeights(Signal):
    """Mean and quantiles of the weights of a projection, and the weights of some synapses, if they change.

    The quantiles of many synapses are those of equally distant ones.

    Args:
        brain: the brain.
        projection: one of :func:`watchable`.
    """

    def __init__(self, brain: Brain, projection: Projection) -> None:
        self._brain, self._projection = brain, projection
        self._period_ns = PERIOD_NS * (1 + projection.size // 1_000_000)
        self._due_ns = 0
        self._last: dict[str, FloatArray] = {}

    def take(self, now_ns: int, add: Add) -> None:
        if now_ns < self._due_ns:
            return
        self._due_ns = (now_ns // self._period_ns + 1) * self._period_ns
        label = self._projection.label
        try:
            weights = (
                self._brain.read_synapses(label).weight if self._grows else self._brain.read_weights(label)
            )
        except CapabilityError:
            return
        self._add(weights_topic(label), summary(weights), now_ns, add)
        if not self._grows:
            self._add(synapses_topic(label), weights[chosen(len(weights))], now_ns, add)

    @property
    def _grows(self) -> bool:
        return self._projection.rewiring is not None

    def _add(self, topic: str, values: FloatArray, now_ns: int, add: Add) -> None:
        if topic in self._last and np.array_equal(values, self._last[topic]):
            return
        self._last[topic] = values
        add(RecordEntry(now_ns, topic, Float64MultiArray, {}, message=Float64MultiArray(data=values)))


def summary(weights: FloatArray) -> FloatArray:
    """Return the numbers of :data:`SUMMARY`; NaN without weights."""
    if not len(weights):
        return np.full(len(SUMMARY), np.nan)
    some = weights[:: -(-len(weights) // _MOST_SORTED)]
    quantiles = np.quantile(some, _QUANTILES)
    quantiles[[0, -1]] = weights.min(), weights.max()
    return np.concatenate([[weights.mean()], quantiles])
