"""The machine as a brain of the platform.

Time and ticks: tick ``k`` begins at ``k`` time steps. Its update includes the input that arrives after the
beginning of the previous tick and up to its own beginning. A threshold crossed in that update is within the
time step, so the spike is reported at the end of the step; the machine labels it with the beginning, one step
earlier. Between neurons a delay counts from the label, as on the machine: a spike reported at time ``t`` with
a delay of ``d`` steps acts from ``t + (d - 1)`` steps on.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from nrp_brain_spinnaker.device_input import DeviceInput
from nrp_brain_spinnaker.engine import MachineEngine
from nrp_brain_spinnaker.host.conversion import to_accum
from nrp_brain_spinnaker.live import LiveNetwork
from nrp_brain_spinnaker.loader import load
from nrp_brain_spinnaker.machine.generator import kiss_state
from nrp_brain_spinnaker.machine.poisson import Sources, change_sources, draw, load_sources
from nrp_brain_spinnaker.models import cell_models
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_brain_spinnaker.readout import read
from nrp_brain_spinnaker.synapses.sites import seed_sites
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.changes import ParameterChange, Rewirings, Synapses
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.network.data import Network, Population, Projection
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS
from nrp_core.findings import Code
from nrp_core.findings.refusals import no_variable


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
