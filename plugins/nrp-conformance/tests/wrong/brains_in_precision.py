"""Brains without a time grid, with one bug each in how precisely they store their synapses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from nrp_brain_event import EventBackend
from registry import Found, register

from nrp_core.brain.backend import BrainOptions
from nrp_core.brain.interface import Brain
from nrp_core.network.data import Network, Projection

FOUND_BY: Found = {}


class _StoresSynapses(EventBackend):
    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        stored = tuple(self.stored(one) for one in network.projections)
        return super().open(replace(network, projections=stored), seed=seed, options=options)

    def stored(self, projection: Projection) -> Projection:
        return projection


found_by = register(FOUND_BY, _StoresSynapses, "")


@found_by("weights_are_used_as_precisely_as_they_are_given")
class RoundsWeightsToSixteenBits(_StoresSynapses):
    def stored(self, projection: Projection) -> Projection:
        return replace(projection, weight=projection.weight.astype(np.float16).astype(float))


@found_by("weights_are_used_as_precisely_as_they_are_given")
class RoundsWeightsToAFixedPoint(_StoresSynapses):
    """Sixteen bits for the weights of a projection, as on neuromorphic hardware."""

    def stored(self, projection: Projection) -> Projection:
        step = max(np.abs(projection.weight).max(), 1e-9) / 2**15
        return replace(projection, weight=np.round(projection.weight / step) * step)


@found_by("weights_are_used_as_precisely_as_they_are_given")
class RoundsWeightsToThirtyTwoBits(_StoresSynapses):
    def stored(self, projection: Projection) -> Projection:
        return replace(projection, weight=projection.weight.astype(np.float32).astype(float))


@found_by("delays_are_used_as_precisely_as_they_are_given")
class RoundsDelaysToATenth(_StoresSynapses):
    def stored(self, projection: Projection) -> Projection:
        delays_ms = projection.delay_ms  # 0 where synapses follow a voltage
        return replace(projection, delay_ms=np.maximum(0.1 * (delays_ms > 0), np.round(delays_ms, 1)))


@found_by("delays_are_used_as_precisely_as_they_are_given")
class RoundsDelaysToMicroseconds(_StoresSynapses):
    def stored(self, projection: Projection) -> Projection:
        return replace(projection, delay_ms=np.round(projection.delay_ms, 3))
