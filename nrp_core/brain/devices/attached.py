"""The devices of a brain, their state by name, and the neurons to which they can be attached."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray
from nrp_core._support.checked_arguments import require_kind
from nrp_core.brain.devices.sinks import SinkPort, StateRecorderPort
from nrp_core.brain.devices.source_cells import PopulationTrains
from nrp_core.brain.devices.sources import CurrentPort, CurrentSpec, SourcePort, SourceSpec
from nrp_core.errors import LifecycleError, NeuronSelectionError, SnapshotError
from nrp_core.network.currents import Injections
from nrp_core.network.data import Network
from nrp_core.seeds import Seeds


def global_ids(network: Network, neurons: npt.ArrayLike) -> IntArray:
    """Return global ids.

    Raises:
        NeuronSelectionError: a neuron does not exist, or is not given by a whole number.
    """
    given = np.asarray(neurons)
    if given.size and given.dtype.kind not in "iu":
        raise NeuronSelectionError(
            f"neurons are given by their global ids, whole numbers, not by {neurons!r:.60}; "
            "network.neurons(NAME) returns those of a population"
        )
    ids = np.atleast_1d(given.astype(np.int64, copy=False))
    if ids.size and not (ids.min() >= 0 and ids.max() < network.size):
        raise NeuronSelectionError(f"neuron ids lie in 0..{network.size - 1}, not {ids.tolist()}")
    return ids


def require_spec(spec: object, kind: type, name: str) -> None:
    """Check that a device is described as one that drives neurons, or as one that reads them.

    Raises:
        ArgumentError: its name is not a text.
        NeuronSelectionError: it is not.
    """
    require_kind("a device", "name", str, name)
    if not isinstance(spec, kind):
        raise NeuronSelectionError(f"the device '{name}' is {spec!r:.60}, not a {kind.__name__}")


def drivable(network: Network, neurons: npt.ArrayLike, name: str, spec: SourceSpec) -> IntArray:
    """Return global ids of cells that a device of some name can drive.

    Raises:
        NeuronSelectionError: a neuron does not exist, is a source itself, or takes no current.
    """
    ids = global_ids(network, neurons)
    if (label := source_among(network, ids)) is not None:
        raise NeuronSelectionError(
            f"'{name}' cannot drive neurons of population '{label}', which only emit spikes"
        )
    relays = (one for one in network.populations.values() if one.is_relay and isinstance(spec, CurrentSpec))
    for label in (one.label for one in relays if np.isin(ids, network.ids_of(one.label)).any()):
        raise NeuronSelectionError(
            f"'{name}' cannot inject a current into population '{label}', which only repeats spikes; "
            "drive it by a source of spikes"
        )
    return ids


def source_among(network: Network, ids: IntArray) -> str | None:
    """Return the first population of source cells that some of these neurons belong to."""
    for label, population in network.populations.items():
        first = network.offsets[label]
        if population.is_source and ((ids >= first) & (ids < first + population.size)).any():
            return label
    return None


class AttachedDevices:
    """The devices of a brain, and the source populations that are emitted like devices.

    Args:
        trains: the source populations whose spikes the core emits.
        injected: the currents of the network.

    Attributes:
        trains, injected: as given.
        sources, sinks: the devices, in the order in which they were added.
        acting: the sources in the order in which they act, that of their names. Sums of floats would depend
            on the order in which they were added, that of the transfer functions.
        currents: the sources that are currents, in that order.
        recorders: the sinks that record state.
    """

    def __init__(self, trains: Sequence[PopulationTrains], injected: Injections) -> None:
        self.trains, self.injected = trains, injected
        self.sources: list[SourcePort] = []
        self.sinks: list[SinkPort] = []
        self._sort()

    def add(self, port: SourcePort | SinkPort) -> None:
        """Add a device."""
        if isinstance(port, SourcePort):
            self.sources.append(port)
        else:
            self.sinks.append(port)
        self._sort()

    def remove(self, port: SourcePort | SinkPort) -> None:
        """Remove a device.

        Raises:
            LifecycleError: it is not attached.
        """
        attached: list[Any] = self.sources if isinstance(port, SourcePort) else self.sinks
        if port not in attached:
            raise LifecycleError(f"{port!r:.60} is not a device of this brain, or it is removed already")
        attached.remove(port)
        self._sort()

    def reset(self, seeds: Seeds) -> None:
        """Return all to time 0, and activate all.

        Args:
            seeds: the random streams of the brain.
        """
        self.reset_trains(seeds)
        for source in self.sources:
            source.active = True
            source.reset(seeds.child("device"))
        for sink in self.sinks:
            sink.active = True
            sink.reset()

    def reset_trains(self, seeds: Seeds) -> None:
        """Return the source populations to time 0."""
        for train in self.trains:
            train.reset(seeds)

    def save(self) -> tuple[list[str], list[object]]:
        """Return the names of the devices, and the states of source populations and devices."""
        return self._names(), [each.save() for each in self._stateful()]

    def restore(self, names: Sequence[str], states: Sequence[Any]) -> None:
        """Restore states from :meth:`save`; devices may have been added in another order since.

        Raises:
            SnapshotError: other devices were saved.
        """
        then, now = [""] * len(self.trains) + list(names), [""] * len(self.trains) + self._names()
        if sorted(then) != sorted(now):
            raise SnapshotError(f"the snapshot has other devices than the brain: {list(names)}")
        states_of: dict[str, list[Any]] = {}
        for name, state in zip(then, states, strict=True):
            states_of.setdefault(name, []).append(state)
        for name, device in zip(now, self._stateful(), strict=True):
            device.restore(states_of[name].pop(0))

    def _sort(self) -> None:
        self.acting = sorted(self.sources, key=lambda source: source.name)
        self.currents = [source for source in self.acting if isinstance(source, CurrentPort)]
        self.recorders = [sink for sink in self.sinks if isinstance(sink, StateRecorderPort)]

    def _stateful(self) -> Iterable[PopulationTrains | SourcePort | SinkPort]:
        return [*self.trains, *self._ports()]

    def _names(self) -> list[str]:
        return [f"{type(port).__name__} {port.name}" for port in self._ports()]

    def _ports(self) -> list[SourcePort | SinkPort]:
        return [*self.sources, *(sink for sink in self.sinks if not sink.passing)]
