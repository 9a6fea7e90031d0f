"""The number of spikes of each neuron in a run."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.devices.sinks import SinkPort, SinkSpec
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.indices import indices_of
from nrp_core.brain.spikes import Spikes

_AT_ONCE = 64
"""Windows whose spikes are counted together; for a few spikes the call costs more than the sum."""
_AUTOMATIC = re.compile(r"population\d+")
"""Automatic names of populations without a label in their script."""


@dataclass(frozen=True, slots=True)
class SpikeCounter(SinkSpec):
    """Counts the spikes of each neuron."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> SpikeCounterPort:
        return SpikeCounterPort(neurons, n_neurons, name)


class SpikeCounterPort(SinkPort):
    """A connected spike counter."""

    def __init__(self, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self._sums = np.zeros(n_neurons, np.int64)
        self._uncounted: list[IntArray] = []
        self._reached: IntArray | None = None

    def activity(self, network: Network) -> dict[str, int]:
        """Return the number of all spikes, and of the synapses that they reached."""
        if self._reached is None:
            self._reached = synapses_from(network)
        return {"spikes": int(self._counts.sum()), "synaptic_events": int(self._counts @ self._reached)}

    def of(self, network: Network) -> dict[str, int]:
        """Return the spikes of every view and population by its name.

        A population with an automatic name is left out if a view has the same neurons.
        """
        named = {label: network.neurons(label) for label in network.views}
        viewed = {neurons.tobytes() for neurons in named.values()}
        for label in network.populations:
            neurons = network.neurons(label)
            if label not in named and not (_AUTOMATIC.fullmatch(label) and neurons.tobytes() in viewed):
                named[label] = neurons
        return {label: int(self._counts[neurons].sum()) for label, neurons in named.items()}

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        if len(spikes):
            self._uncounted.append(spikes.neurons)
            if len(self._uncounted) >= _AT_ONCE:
                self._count()

    def _count(self) -> None:
        for neurons in (np.concatenate(self._uncounted),) if self._uncounted else ():
            np.add.at(self._sums, neurons, 1)
        self._uncounted.clear()

    @property
    def _counts(self) -> IntArray:
        """The number of spikes of each neuron."""
        self._count()
        return self._sums

    def reset(self) -> None:
        self._uncounted.clear()
        self._sums[:] = 0

    def save(self) -> object:
        return self.active, self._counts.copy()

    def restore(self, saved: Any) -> None:
        self.active, counts = saved
        self._counts[:] = counts


def synapses_from(network: Network) -> IntArray:
    """Return the number of synapses of each neuron on others, shape ``(n_neurons,)``."""
    found = np.zeros(network.size, np.int64)
    for projection in network.projections:
        of_population = found[network.offsets[projection.pre] :]
        for pre in indices_of(projection, "pre_index").parts():
            counts = np.bincount(pre)
            of_population[: len(counts)] += counts
    return found
