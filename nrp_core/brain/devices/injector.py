"""A device through which a function sends single spikes to chosen neurons at chosen times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.ports import (
    NO_EVENTS,
    SourcePort,
    SourceSpec,
    check_sign,
    check_synapse,
)
from nrp_core.brain.network.data import Network
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import NeuronSelectionError
from nrp_core.seeds import Seeds


@dataclass(frozen=True, slots=True)
class SpikeInjector(SourceSpec):
    """Spikes into neurons, one by one.

    Args:
        weight: weight in PyNN's units for the target's cell type.
        delay: ms from injection to arrival.
        receptor_type: ``excitatory``, or ``inhibitory``, to which current-based cells take negative weights.
    """

    weight: float = 2.0
    delay: float = 1.0
    receptor_type: str = "excitatory"

    def __post_init__(self) -> None:
        check_synapse(self.weight, self.delay, self.receptor_type)

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> SpikeInjectorPort:
        return SpikeInjectorPort(self, neurons, name)


class SpikeInjectorPort(SourcePort):
    """An active :class:`SpikeInjector`; its spikes are discarded while ``active`` is False."""

    def __init__(self, spec: SpikeInjector, neurons: IntArray, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        self._now_ms = 0.0
        self._places: IntArray = np.empty(0, np.int64)
        self._times_ms: FloatArray = np.empty(0)

    def start(self, now_ms: float, network: Network) -> None:
        check_sign(self._spec.weight, self._spec.receptor_type, self.neurons, network)
        self._now_ms = now_ms

    def inject_spikes(
        self, neuron_ids: npt.ArrayLike | None = None, times_ms: npt.ArrayLike | None = None
    ) -> None:
        """Send a spike to neurons, by default to all.

        Args:
            neuron_ids: indices into the neurons of this device, from 0.
            times_ms: spike times, ms: one for all or one for each neuron; by default the current time.

        Raises:
            NeuronSelectionError: a neuron does not exist.
            ValueError: a time lies in the past.
        """
        n = len(self.neurons)
        places = np.arange(n) if neuron_ids is None else np.atleast_1d(np.asarray(neuron_ids, dtype=np.int64))
        if places.size and not (places.min() >= 0 and places.max() < n):
            raise NeuronSelectionError(f"'{self.name}' drives neurons 0..{n - 1}, not {places.tolist()}")
        given = self._now_ms if times_ms is None else np.asarray(times_ms, dtype=float)
        times = np.broadcast_to(given, places.shape)
        if not (np.isfinite(times).all() and (times >= self._now_ms).all()):
            raise ValueError(
                f"'{self.name}' cannot send a spike at {times.min():g} ms: it is {self._now_ms:g} ms"
            )
        if self.active:
            self._places = np.concatenate([self._places, places])
            self._times_ms = np.concatenate([self._times_ms, times])

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        self._now_ms = until_ms
        if not len(self._places):
            return NO_EVENTS
        due = self._times_ms <= until_ms
        times, places = self._times_ms[due] + self._spec.delay, self._places[due]
        self._times_ms, self._places = self._times_ms[~due], self._places[~due]
        order = np.argsort(times, kind="stable")
        weights = np.full(len(order), self._spec.weight)
        return SynapticEvents(self.neurons[places[order]], times[order], weights, self._spec.receptor_type)

    def reset(self, seeds: Seeds) -> None:
        self._now_ms = 0.0
        self._places, self._times_ms = np.empty(0, np.int64), np.empty(0)

    def save(self) -> object:
        return self.active, self._now_ms, self._places, self._times_ms

    def restore(self, saved: Any) -> None:
        self.active, self._now_ms, self._places, self._times_ms = saved
