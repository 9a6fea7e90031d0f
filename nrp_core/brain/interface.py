"""The brain side: what a spiking simulator must offer to take part in the loop.

A minimal backend writes six methods: advance, spikes out, spikes of source cells in, synaptic events in,
current in, reset. Devices, source populations, random trains and their timing are
supplied here, once for all backends.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from nrp_core.brain.network import FloatArray, IntArray, Network, Population
from nrp_core.brain.sinks import SinkPort, SinkSpec
from nrp_core.brain.source_cells import PopulationTrains
from nrp_core.brain.sources import SourcePort, SourceSpec
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.diagnosis import Diagnosis
from nrp_core.errors import CapabilityError, DivergedError, NeuronSelectionError, SnapshotError
from nrp_core.seeds import Seeds
from nrp_core.simulation import INTERFACE_VERSION, Determinism, Simulation


class BrainOptions(BaseModel):
    """Base of a backend's options, as an experiment file gives them; unknown names are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


@dataclass(frozen=True, slots=True)
class BrainCapabilities:
    """What a brain backend has, asked as questions.

    Args:
        cells: which PyNN standard cells can it simulate?
        synapses: which synapse types?
        extensions: which of these are additions to what the simulator is known for?
        approximate: which cells does it solve so roughly that they leave their equations by more than the
            resolution explains?
        resolution_ns: on which grid do its events lie? None: they are exact.
        determinism: how far do two runs agree?
        state_variables: which state can be read and set while running?
        snapshot: can its state be saved and restored?
        releases_gil: can it step while Python code runs in another thread?
    """

    cells: frozenset[str]
    synapses: frozenset[str]
    extensions: frozenset[str] = frozenset()
    approximate: frozenset[str] = frozenset()
    resolution_ns: int | None = None
    determinism: Determinism = Determinism.MACHINE
    state_variables: frozenset[str] = frozenset()
    snapshot: bool = False
    releases_gil: bool = False


class Brain(Simulation):
    """A network in a simulator, at a time.

    Args:
        network: what is simulated.
        seed: the experiment's seed for the brain.
        capabilities: what the backend has.
        identity: text that names backend and options.
    """

    def __init__(
        self, network: Network, *, seed: int, capabilities: BrainCapabilities, identity: str
    ) -> None:
        super().__init__(seed=seed, identity=f"{identity}:{network.digest}")
        self.network = network
        self.capabilities = capabilities
        self.warnings: list[str] = []
        self._require_capabilities()
        self._sources: list[SourcePort] = []
        self._sinks: list[SinkPort] = []
        self._currents = np.zeros(network.size)
        self._trains = [
            PopulationTrains(population, network.ids_of(label), self._seeds)
            for label, population in network.populations.items()
            if population.is_source and not self._emits(population)
        ]

    # -- devices

    @final
    def add_source(self, spec: SourceSpec, neurons: npt.ArrayLike, *, name: str) -> SourcePort:
        """Let a source act on neurons from now on.

        Args:
            spec: the source, e.g. :class:`~nrp_core.brain.sources.PoissonSource`.
            neurons: global ids.
            name: names its random stream; equal names, equal trains.

        Raises:
            NeuronSelectionError: there is no such neuron, or it is a source itself.
        """
        self._require_ready()
        port = spec.open(self._targets(neurons, name), self._seeds.child("device"), name)
        self._sources.append(port)
        return port

    @final
    def add_sink(self, spec: SinkSpec, neurons: npt.ArrayLike, *, name: str) -> SinkPort:
        """Let a sink listen to neurons (global ids) from now on."""
        self._require_ready()
        port = spec.open(self._selected(neurons), self.network.size, name)
        port.receive(Spikes(), milliseconds(self._now_ns))
        self._sinks.append(port)
        return port

    @final
    def remove(self, port: SourcePort | SinkPort) -> None:
        """Take a device away; the network is as if it had never been there, but for what it did."""
        if isinstance(port, SourcePort):
            self._sources.remove(port)
        else:
            self._sinks.remove(port)

    @property
    def devices(self) -> tuple[SourcePort | SinkPort, ...]:
        """All sources and sinks at work, in the order in which they were added."""
        return (*self._sources, *self._sinks)

    # -- state

    @final
    def read_state(self, variable: str, neurons: npt.ArrayLike) -> FloatArray:
        """Return a state variable (``v`` in mV, ...) of neurons (global ids) as it is now."""
        self._require_ready()
        if variable not in self.capabilities.state_variables:
            known = ", ".join(sorted(self.capabilities.state_variables)) or "none"
            raise CapabilityError(f"{type(self).__name__} does not show '{variable}'; it shows: {known}")
        with self._guarded("read state"):
            return self._do_read_state(variable, self._selected(neurons))

    # -- the sequence of one advance, the same for every backend

    @property
    def _seeds(self) -> Seeds:
        return Seeds(self._seed).child("brain")

    def _advance(self, t_ns: int) -> None:
        since_ms, until_ms = milliseconds(self._now_ns), milliseconds(t_ns)
        emitted = [train.emitted(since_ms, until_ms) for train in self._trains]
        for ids, times_ms in emitted:
            if len(ids):
                self._do_fire(ids, times_ms)
        for source in self._sources:
            events = source.events(since_ms, until_ms)
            if len(events):
                self._do_inject(events)
        self._run_under_currents(t_ns)
        spikes = self._do_take_spikes()
        if len(spikes) and not np.isfinite(spikes.times_ms).all():
            raise DivergedError(f"{type(self).__name__} gave a spike time that is not finite", t_ns=t_ns)
        spikes = Spikes.merged([spikes, *(Spikes(ids, times) for ids, times in emitted)])
        for sink in self._sinks:
            sink.receive(spikes, until_ms)

    def _run_under_currents(self, t_ns: int) -> None:
        """Run to ``t_ns``, halting where a current changes by itself, on the brain's own grid."""
        grid_ns = self.capabilities.resolution_ns or 1
        at_ns = self._now_ns
        while at_ns < t_ns:
            now_ms = milliseconds(at_ns)
            self._update_currents(now_ms)
            change_ms = min((source.next_change_ms(now_ms) for source in self._sources), default=inf)
            stop_ns = t_ns
            if change_ms < milliseconds(t_ns):
                stop_ns = min(t_ns, -(-round(change_ms * NS_PER_MS) // grid_ns) * grid_ns)
            self._do_run_until(stop_ns)
            at_ns = stop_ns

    def _update_currents(self, now_ms: float) -> None:
        total: FloatArray | None = None
        for source in self._sources:
            current = source.current_na(now_ms)
            if current is not None:
                total = np.zeros(self.network.size) if total is None else total
                np.add.at(total, source.neurons, current)
        if total is None:
            if not self._currents.any():
                return
            total = np.zeros(self.network.size)
        if (total != self._currents).any():
            self._currents = total
            self._do_set_current(total)

    def _reset(self) -> None:
        for train in self._trains:
            train.reset(self._seeds)
        for source in self._sources:
            source.reset(self._seeds.child("device"))
        for sink in self._sinks:
            sink.reset()
        self._currents = np.zeros(self.network.size)
        self._do_reset(self._seed)

    def _save(self) -> object:
        self._require_snapshot()
        devices = [device.save() for device in self._devices()]
        return self._seed, self._currents, self._device_names(), devices, self._do_save()

    def _load(self, saved: Any) -> None:
        self._require_snapshot()
        seed, currents, names, devices, state = saved
        if names != self._device_names():
            raise SnapshotError(f"the snapshot has other devices than the brain: {names}")
        self._seed, self._currents = seed, currents
        for device, state_of in zip(self._devices(), devices, strict=True):
            device.restore(state_of)
        self._do_restore(state)

    def _devices(self) -> Iterable[PopulationTrains | SourcePort | SinkPort]:
        return [*self._trains, *self._sources, *self._sinks]

    def _device_names(self) -> list[str]:
        return [f"{type(port).__name__} {port.name}" for port in self.devices]

    def _targets(self, neurons: npt.ArrayLike, name: str) -> IntArray:
        ids = self._selected(neurons)
        for label, population in self.network.populations.items():
            first = self.network.offsets[label]
            if population.is_source and ((ids >= first) & (ids < first + population.size)).any():
                raise NeuronSelectionError(
                    f"'{name}' cannot drive neurons of population '{label}', which only emit spikes"
                )
        return ids

    def _selected(self, neurons: npt.ArrayLike) -> IntArray:
        ids = np.atleast_1d(np.asarray(neurons, dtype=np.int64))
        if ids.size and not (ids.min() >= 0 and ids.max() < self.network.size):
            raise NeuronSelectionError(f"neuron ids lie in 0..{self.network.size - 1}, not {ids.tolist()}")
        return ids

    def _require_capabilities(self) -> None:
        name = type(self).__name__
        for population in self.network.populations.values():
            if not population.is_source and population.cell_type not in self.capabilities.cells:
                raise CapabilityError(
                    f"{name} has no cells of type {population.cell_type} (population "
                    f"'{population.label}'); it has {', '.join(sorted(self.capabilities.cells))}"
                )
        for projection in self.network.projections:
            if projection.synapse_type not in self.capabilities.synapses:
                raise CapabilityError(
                    f"{name} has no {projection.synapse_type} synapses (projection "
                    f"'{projection.label}'); it has {', '.join(sorted(self.capabilities.synapses))}"
                )

    def _require_snapshot(self) -> None:
        if not self.capabilities.snapshot:
            raise CapabilityError(f"{type(self).__name__} cannot save and restore its state")

    # -- for backends: the fewest operations that cannot be derived

    @abstractmethod
    def _do_run_until(self, t_ns: int) -> None:
        """Simulate to exactly ``t_ns``."""

    @abstractmethod
    def _do_take_spikes(self) -> Spikes:
        """Return and forget the spikes since the last call but those that the core emits; any order."""

    @abstractmethod
    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Let source cells (global ids) emit spikes at exact times in the window to come."""

    @abstractmethod
    def _do_inject(self, events: SynapticEvents) -> None:
        """Let events arrive at synapses of non-source cells; arrivals may lie beyond the window to come."""

    @abstractmethod
    def _do_set_current(self, currents_na: FloatArray) -> None:
        """Hold these currents into all cells from now on, shape ``(network.size,)``."""

    @abstractmethod
    def _do_reset(self, seed: int) -> None:
        """Return to the state right after opening."""

    def _emits(self, population: Population) -> bool:
        """Whether the simulator emits the spikes of a source population itself; else the core draws them."""
        return False

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        """Return a declared state variable of cells."""
        raise NotImplementedError(variable)

    def _do_save(self) -> object:
        """Return the complete state as something that pickles."""
        raise NotImplementedError

    def _do_restore(self, saved: object) -> None:
        """Return to what :meth:`_do_save` gave."""
        raise NotImplementedError


class BrainBackend(ABC):
    """The entry point of a brain simulator; importing and constructing it is cheap.

    Attributes:
        interface_version: the version of the interfaces it was written for.
        options: the model of its options.
    """

    interface_version: ClassVar[int] = INTERFACE_VERSION
    options: ClassVar[type[BrainOptions]] = BrainOptions

    @abstractmethod
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        """Return what the backend has under these options; does not load the simulator."""

    def diagnose(self) -> list[Diagnosis]:
        """Look at this machine for what the backend needs; may load the simulator."""
        return []

    @abstractmethod
    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        """Load a network into the simulator, at time 0."""
