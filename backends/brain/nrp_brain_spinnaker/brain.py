"""The machine as a brain of the platform.

Time and ticks: tick ``k`` begins at ``k`` time steps. Its update includes the input that arrives after the
beginning of the previous tick and up to its own beginning. A threshold crossed in that update is within the
time step, so the spike is reported at the end of the step; the machine labels it with the beginning, one step
earlier. Between neurons a delay counts from the label, as on the machine: a spike reported at time ``t`` with
a delay of ``d`` steps acts from ``t + (d - 1)`` steps on.

Input from devices: events whose weights were unknown when the shifts were chosen.

A device is not part of the network and must not change it, so its input does not pass through the 16-bit ring
buffer, where it would use headroom of the network's weights or lose bits. Its weight is converted to s16.15,
as the host converts any number (conductances times 1024), and is added to the buffer's value after the shift.
Several events in one tick are summed.

State of neurons between two ticks, in users' units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from nrp_brain_spinnaker.engine import MachineEngine
from nrp_brain_spinnaker.host.cells import GATES, ROWS, Grid, state_scale
from nrp_brain_spinnaker.host.weights import weight_factors
from nrp_brain_spinnaker.live import LiveNetwork
from nrp_brain_spinnaker.loader import load
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import from_accum, to_accum
from nrp_brain_spinnaker.machine.generator import Sources, change_sources, draw, kiss_state, load_sources
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.neuron_kernels import OPEN
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring, add_arrived, read_values, transfer
from nrp_brain_spinnaker.models import GSYN, ISYN, CellModel, cell_models
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_brain_spinnaker.synapses.sites import seed_sites
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError
from nrp_core.findings import Code
from nrp_core.findings.refusals import no_variable
from nrp_core.network.changes import ParameterChange, Rewirings, Synapses
from nrp_core.network.data import RECEPTORS, Network, Population, Projection


class DeviceInput:
    """Converts events for the neurons of a machine.

    Args:
        cells: the neurons.
        models: the cell type of each population.
        grid: the time step.
        n_sources: number of global ids.

    Attributes:
        lost: whether a weight was below the machine's resolution.
    """

    def __init__(self, cells: Cells, models: Sequence[CellModel], grid: Grid, n_sources: int) -> None:
        self.lost = False
        self._grid, self._n_sources = grid, n_sources
        n = cells.ids.size
        self._line_of = np.full(2 * n_sources, -1, np.int64)
        self._line_of[cells.ids], self._line_of[cells.ids + n_sources] = np.arange(n), np.arange(n, 2 * n)
        factor = np.ones((2, n))
        for population, model in enumerate(models):
            own = cells.neurons(population)
            factors = weight_factors(cells, own, model)
            factor[:, own] = model.weight_scale * (1.0 if factors is None else factors)
            if not model.is_conductance_based:
                factor[1, own] *= -1  # PyNN's inhibitory currents are negative; the machine subtracts
        self._factor = factor.ravel()

    def convert(self, parts: Sequence[SynapticEvents]) -> IntArray:
        """Return tick, line and s16.15 value of each event, shape ``(3, n)``.

        Raises:
            CapabilityError: an event is for a source cell or too large for the machine's numbers.
        """
        lines = self._line_of[np.concatenate([self._places(part) for part in parts])]
        if lines.min() < 0:
            raise CapabilityError("source cells only emit spikes; a device cannot act on them")
        sizes = np.concatenate([part.weights for part in parts]) * self._factor[lines]
        entries = np.empty((3, lines.size), np.int64)
        entries[0] = self._grid.first_tick_at(np.concatenate([part.times_ms for part in parts]))
        entries[1] = lines
        try:
            entries[2] = to_accum(sizes, "the weight of a device")
        except ValueError as error:
            raise CapabilityError(str(error)) from None
        if not entries[2].all():
            self.lost = self.lost or bool(sizes[entries[2] == 0].any())
        return entries

    def _places(self, events: SynapticEvents) -> IntArray:
        """Return the indices of the targets' lines in the table."""
        inhibitory = RECEPTORS.index(events.receptor)
        return events.neurons + self._n_sources if inhibitory else events.neurons


def read(cells: Cells, ring: Ring, tick: int, population: int, model: CellModel, variable: str) -> FloatArray:
    """Return a state variable of a population at the beginning of a tick."""
    own = cells.neurons(population)
    if variable in GATES:
        return np.asarray(cells.state[GATES[variable], own] / OPEN)
    if variable not in (*GSYN, *ISYN):
        return from_accum(cells.state[ROWS[variable], own]) / state_scale(model, variable)
    values = _with_input(cells, ring, tick, population)
    raw = values[int(variable.endswith("inh"))]
    if model.input == kinds.CONDUCTANCE:  # the machine uses and records it without the last ten bits
        return from_accum(raw >> 10)
    return from_accum(raw) / state_scale(model, variable)


def _with_input(cells: Cells, ring: Ring, tick: int, population: int) -> IntArray:
    """Return the synaptic values that a machine records, with the input of the tick, shape ``(2, n)``."""
    own, n = cells.neurons(population), cells.ids.size
    size = own.stop - own.start
    parts = cells.populations[[population]]
    parts[0, [kinds.FIRST, kinds.LAST]] = 0, size
    apart = cells._replace(
        populations=parts, synapse_constants=cells.synapse_constants[..., own].copy(),
        synapse_state=cells.synapse_state[..., own].copy(), ids=cells.ids[own].copy(),
        arrived=np.zeros((2, size), np.int64), value=np.empty((2, size), np.int64),
    )  # fmt: skip
    lines = [slice(first + own.start, first + own.stop) for first in (0, n)]
    now = ring.slots[tick & (ring.slots.shape[0] - 1)]
    waiting = (np.concatenate([line[each] for each in lines]) for line in (now, ring.device, ring.saturated))
    slots, device, saturated = waiting
    transfer(apart, Ring(slots[None], device, saturated), 0, 0)
    add_arrived(apart, 0)
    read_values(apart, 0)
    return apart.value


class SpinnakerBrain(Brain):
    """A network on the emulated machine.

    Args:
        network: the simulated network.
        seed: the seed of the brain's random numbers; on the machine only Poisson sources use it.
        capabilities: the backend's capabilities.
        options: the user's options.

    Raises:
        CapabilityError, NetworkError: the network does not fit the machine.
    """

    def __init__(
        self, network: Network, *, seed: int, capabilities: BrainCapabilities, options: SpinnakerOptions
    ) -> None:
        self._options = options
        identity = f"spinnaker:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        loaded = load(network, options)
        self.warnings += loaded.warnings
        self._engine = MachineEngine(loaded.machine, loaded.rewired)
        self._live = LiveNetwork(network, loaded, options)
        self._cells, self._grid = loaded.machine.cells, loaded.grid
        simulated = [population for population in network.populations.values() if not population.is_source]
        self._index = {population.label: index for index, population in enumerate(simulated)}
        models = [cell_models(options.semantics)[population.cell_type] for population in simulated]
        self._devices_in = DeviceInput(self._cells, models, loaded.grid, network.size)
        sizes = [population.size for population in simulated]
        self._current_scale = np.repeat([model.current_scale for model in models], sizes)
        self._poisson = self._load_poisson()
        self._spikes: list[Spikes] = []
        self._injected: list[SynapticEvents] = []
        self._sites = loaded.sites
        self._seed_sites()
        self._initial = self._engine.save(), self._live.save()

    @property
    def saturations(self) -> Mapping[str, tuple[int, int]]:
        """Number of saturated ring-buffer entries of each population, excitatory and inhibitory."""
        lost = self._engine.machine.ring.saturated.reshape(2, -1)
        sums = {label: lost[:, self._cells.neurons(k)].sum(axis=1) for label, k in self._index.items()}
        return {label: (int(both[0]), int(both[1])) for label, both in sums.items()}

    def _do_run_until(self, t_ns: int) -> None:
        until = t_ns // self._options.timestep
        self._take_injected()
        self._draw_until(until)
        self._spikes.append(self._reported(self._engine.run(until)))
        if self._engine.machine.ring.saturated.any():
            lossy = [f"'{label}'" for label, counts in self.saturations.items() if any(counts)]
            message = f"input beyond the 16 bits of a ring buffer was lost: population {', '.join(lossy)}"
            self.warnings.add(Code.NRP277, message)

    def _reported(self, spikes: IntArray) -> Spikes:
        ticks, ids = spikes
        return Spikes(ids, (ticks + 1) * self._options.timestep / NS_PER_MS)

    def _do_take_spikes(self) -> Spikes:
        spikes, self._spikes = Spikes.merged(self._spikes), []
        return spikes

    # -- input

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        self._engine.source_spikes.add(np.stack([self._grid.first_tick_at(times_ms), neurons]))

    def _do_inject(self, events: SynapticEvents) -> None:
        self._injected.append(events)

    def _take_injected(self) -> None:
        """Pass all new events from devices to the engine."""
        if self._injected:
            self._engine.device_input.add(self._devices_in.convert(self._injected))
            self._injected = []
        if self._devices_in.lost:
            self.warnings.add(Code.NRP277, "a device's weight is below the machine's resolution and was lost")

    def _draw_until(self, until: int) -> None:
        """Pass the spikes of the machine's own sources to the engine."""
        drawn = draw(self._poisson, self._engine.tick, until)
        if drawn.size:
            self._engine.source_spikes.add(drawn)
            self._spikes.append(self._reported(drawn))

    def _do_set_current(self, currents_na: FloatArray) -> None:
        currents = currents_na[self._cells.ids] * self._current_scale
        self._cells.current[:] = to_accum(currents, "an injected current in nA")

    # -- sources with spikes drawn by the machine

    def _emits(self, population: Population) -> bool:
        return self._options.poisson == "machine" and population.cell_type == "SpikeSourcePoisson"

    def _load_poisson(self) -> Sources:
        own = [p for p in self.network.populations.values() if p.is_source and self._emits(p)]
        populations = [(population, self.network.ids_of(population.label)) for population in own]
        return load_sources(
            populations, self._options.step_us, partial(kiss_state, self._seeds.child("machine"))
        )

    # -- synapses that form and vanish

    def _seed_sites(self) -> None:
        if self._engine.rewired is not None:
            drawn = partial(kiss_state, self._seeds.child("rewiring"))
            seed_sites(self._engine.rewired, self._sites, drawn)

    def _do_read_synapses(self, projection: Projection) -> Synapses:
        return self._live.synapses(projection.label)

    def _do_read_rewirings(self, projection: Projection) -> Rewirings:
        return self._live.rewirings(projection.label, self._engine.changes)

    # -- changes while it runs

    def _do_set_parameters(self, change: ParameterChange) -> None:
        population = self._live.set_parameters(change)
        if population.is_source:
            ids = self.network.ids_of(population.label)
            change_sources(self._poisson, population, ids, self._options.step_us)

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return self._live.weights(projection.label, projection.size)

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        self._live.set_weights(projection.label, weights)

    # -- state

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        values = np.empty(len(neurons))
        for label, first in self.network.offsets.items():
            population = self.network.populations[label]
            chosen = (neurons >= first) & (neurons < first + population.size)
            if chosen.any():
                known = cell_models(self._options.semantics).get(population.cell_type)
                if known is None or variable not in known.state_variables:
                    raise no_variable(label, variable)
                ring, tick = self._engine.machine.ring, self._engine.tick
                state = read(self._cells, ring, tick, self._index[label], known, variable)
                values[chosen] = state[neurons[chosen] - first]
        return values

    def _do_reset(self, seed: int) -> None:
        engine, live = self._initial
        self._live.restore(live)
        self._engine.restore(engine)
        self._seed_sites()
        self._poisson = self._load_poisson()
        self._spikes, self._injected = [], []

    def _do_save(self) -> object:
        self._take_injected()
        poisson = self._poisson
        sources = poisson.countdown.copy(), poisson.generators.copy(), poisson.settings.copy()
        return self._engine.save(), self._live.save(), sources

    def _do_restore(self, saved: Any) -> None:
        engine, live, (countdown, generators, settings) = saved
        self._live.restore(live)
        self._engine.restore(engine)
        self._poisson.countdown[:], self._poisson.generators[:] = countdown, generators
        self._poisson.settings[:] = settings
        self._spikes, self._injected = [], []

    def _do_close(self) -> None:
        """Do nothing, because only memory is held."""
