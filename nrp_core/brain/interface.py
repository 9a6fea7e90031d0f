"""The interface that a spiking simulator implements to take part in the loop.

A minimal backend implements six methods: advance, spikes out, spikes of source cells in, synaptic events in,
current in, reset. Devices, source populations, random spike trains and their timing are implemented here,
once for all backends.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isfinite, prod
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray, unset
from nrp_core._support.checked_arguments import is_number
from nrp_core._support.overview import Overview, Row
from nrp_core.brain.capabilities import BrainCapabilities as BrainCapabilities
from nrp_core.brain.devices.attached import AttachedDevices, drivable, global_ids, require_spec, source_among
from nrp_core.brain.devices.sinks import (
    SinkPort,
    SinkSpec,
    StateRecorderPort,
    Trace,
    run_halting,
    split_samples,
)
from nrp_core.brain.devices.source_cells import PopulationTrains
from nrp_core.brain.devices.sources import SourcePort, SourceSpec
from nrp_core.brain.engines import Engines
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import milliseconds
from nrp_core.errors import DivergedError, NetworkError
from nrp_core.findings import Findings
from nrp_core.findings.refusals import SNAPSHOTS, no_change, no_rewards, no_variable, not_shown, refusal
from nrp_core.network import changes
from nrp_core.network.changes import (
    EQUATIONS,
    PARAMETERS,
    PLASTICITY,
    WEIGHTS,
    ParameterChange,
    Rewirings,
    Synapses,
)
from nrp_core.network.currents import Injections
from nrp_core.network.data import LISTED, Network, Population, Projection
from nrp_core.network.grid import Grid, nearest_ns
from nrp_core.seeds import Seeds
from nrp_core.simulation import Simulation, State, guarded


class Brain(Overview, Simulation):
    """A network in a simulator, at a point in time.

    Args:
        network: the simulated network.
        seed: the seed of the brain's random numbers.
        capabilities: the backend's capabilities.
        identity: a text that names the backend and its options.

    Attributes:
        reads_parameters: whether it needs the parameters of all cells and synapses; a brain without a
            simulator has enough with a description.
    """

    reads_parameters: ClassVar[bool] = True

    def __init__(
        self, network: Network, *, seed: int, capabilities: BrainCapabilities, identity: str
    ) -> None:
        super().__init__(seed=seed, identity=identity)
        self.network = network
        self.warnings = Findings()
        capabilities.require(network, type(self).__name__)
        if self.reads_parameters:
            network.require_complete()
        self.capabilities = capabilities.extended(network)
        step_ns = capabilities.resolution_ns
        self._grid_of_stops = None if step_ns is None else Grid(step_ns, type(self).__name__)
        self._stop_currents()
        self._frozen: frozenset[str] = frozenset()
        self._changed: dict[str, dict[str, FloatArray]] = {}  # parameters by the labels of populations
        self._began_ns = 0  # the time of the run at which the time of the engine is 0
        self._attached = AttachedDevices(
            [
                PopulationTrains(population, network.ids_of(label), self._seeds)
                for label, population in network.populations.items()
                if population.is_source and not self._emits(population)
            ],
            Injections(network.currents, network.size),
        )

    def _overview(self) -> tuple[str, Iterable[Row]]:
        line, rows = self.network._overview()
        return f"{line}, at {milliseconds(self.now_ns):g} ms", rows

    @property
    def identity(self) -> str:
        """See :class:`~nrp_core.simulation.Simulation`; the digest of a large network takes a minute."""
        return f"{super().identity},network {self.network.digest}"

    # -- devices

    @final
    def add_source(self, spec: SourceSpec, neurons: npt.ArrayLike, *, name: str) -> SourcePort:
        """Connect a source to neurons from now on.

        Args:
            spec: the source, e.g. :class:`~nrp_core.brain.devices.sources.PoissonSource`.
            neurons: global ids.
            name: the name of its random stream; equal names give equal trains.

        Raises:
            NeuronSelectionError: a neuron does not exist, is a source itself, or takes no current.
        """
        self.require_ready()
        require_spec(spec, SourceSpec, name)
        port = spec.open(drivable(self.network, neurons, name, spec), self._seeds.child("device"), name)
        port.start(milliseconds(self.now_ns), self.network)
        self._attached.add(port)
        return port

    @final
    def add_sink(self, spec: SinkSpec, neurons: npt.ArrayLike, *, name: str) -> SinkPort:
        """Connect a sink to neurons (global ids) from now on.

        Raises:
            NeuronSelectionError: a neuron does not exist.
            CapabilityError: the sink records a state variable that the backend cannot read.
        """
        self.require_ready()
        require_spec(spec, SinkSpec, name)
        port = spec.open(global_ids(self.network, neurons), self.network.size, name)
        port.receive(Spikes(), milliseconds(self.now_ns))
        if isinstance(port, StateRecorderPort):
            self._sample(port, self.read_state(port.variable, port.neurons))
        self._attached.add(port)
        return port

    @final
    def remove(self, port: SourcePort | SinkPort) -> None:
        """Remove a device; the effects of its past activity remain."""
        self._attached.remove(port)

    @property
    def devices(self) -> tuple[SourcePort | SinkPort, ...]:
        """All active sources and sinks, in the order in which they were added."""
        return (*self._attached.sources, *self._attached.sinks)

    # -- state

    @final
    def read_state(self, variable: str, neurons: npt.ArrayLike) -> FloatArray:
        """Return a state variable (``v`` in mV, ...) of neurons (global ids) at the current time."""
        self.require_ready()
        if not isinstance(variable, str) or variable not in self.capabilities.state_variables:
            raise not_shown(self, variable, self.capabilities.state_variables)
        ids = global_ids(self.network, neurons)
        if (label := source_among(self.network, ids)) is not None:
            raise no_variable(label, variable, source=True)
        with guarded(self, "read state"):
            return self._do_read_state(variable, ids)

    # -- changes of the network while it runs; a reset reverts them

    @final
    def read_parameters(self, population: str) -> dict[str, FloatArray]:
        """Return the current parameters of the cells of a population (by label), in PyNN's names and units.

        Returns:
            Copies of arrays of shape ``(size,)``.

        Raises:
            NeuronSelectionError: the population does not exist.
        """
        self.require_ready()
        self.network.ids_of(population)
        values = {**self.network.populations[population].parameters, **self._changed.get(population, {})}
        return {name: np.array(each, float) for name, each in values.items()}

    @final
    def set_parameters(self, neurons: npt.ArrayLike, values: Mapping[str, npt.ArrayLike]) -> None:
        """Change parameters of cells from now on.

        Args:
            neurons: global ids.
            values: new values by PyNN name, in PyNN's units: one number for all neurons, or one for each.

        Raises:
            CapabilityError: the backend cannot change them while it runs.
            NetworkError: a population has no such parameter, or a value is impossible.
        """
        self.require_ready()
        changed = changes.parameter_changes(self.network, global_ids(self.network, neurons), values)
        trains = {train.label: train for train in self._attached.trains}
        if any(change.label not in trains for change in changed):
            self._require_change(PARAMETERS)
        with guarded(self, "change parameters"):
            for change in changed:
                if change.label in trains:
                    trains[change.label].set_parameters(change.index, change.values)
                else:
                    self._do_set_parameters(change)
                before = self._changed.get(change.label, {})
                population = self.network.populations[change.label]
                self._changed[change.label] = changes.parameters_after(population, before, change)

    @final
    def set_spike_times(
        self, population: str, trains: Sequence[npt.ArrayLike], cells: npt.ArrayLike | None = None
    ) -> None:
        """Replace the spike trains of ``SpikeSourceArray`` cells; times before now are ignored.

        Args:
            population: the population's label.
            trains: ascending times in ms, one train for each cell.
            cells: indices of cells within the population, by default all.

        Raises:
            CapabilityError: the simulator emits these spikes itself.
            NetworkError: not a ``SpikeSourceArray`` population, or times do not ascend.
        """
        self.require_ready()
        index, arrays = changes.spike_trains(self.network, population, trains, cells)
        own = next((train for train in self._attached.trains if train.label == population), None)
        if own is None:
            raise refusal(self, f"cannot change the spikes of '{population}'")
        began_ms = milliseconds(self._began_ns)
        own_now_ms = milliseconds(self.now_ns - self._began_ns)
        own.set_spike_times(index, [each - began_ms for each in arrays], own_now_ms)

    @final
    def read_weights(self, projection: str) -> FloatArray:
        """Return the current weights of a projection (by label), in the order of its synapses.

        Raises:
            CapabilityError: the weights are plastic, and the backend cannot read them.
            NetworkError: the projection does not exist.
        """
        self.require_ready()
        chosen = changes.lasting(changes.projection_of(self.network, projection))
        if WEIGHTS not in self.capabilities.changes and not chosen.is_plastic:
            return chosen.weight.copy()
        self._require_change(WEIGHTS)
        with guarded(self, "read weights"):
            return self._do_read_weights(chosen)

    @final
    def learned_network(self) -> Network:
        """Return the network with its present weights in place of the initial ones.

        Raises:
            CapabilityError: synapses form and vanish in it, or the backend cannot read weights.
        """
        for one in self.network.projections:
            if one.rewiring is not None:
                raise refusal(self, f"cannot keep the synapses of '{one.label}', which form and vanish")
        projections = []
        for one in self.network.projections:
            may_change = one.is_plastic or (WEIGHTS in self.capabilities.changes and not one.is_continuous)
            weights = self.read_weights(one.label) if may_change else one.weight
            same = np.array_equal(weights, one.weight)
            projections.append(one if same else replace(one, weight=weights, origin=LISTED))
        return replace(self.network, projections=tuple(projections))

    @final
    def read_synapses(self, projection: str) -> Synapses:
        """Return a copy of the current synapses of a projection (by label).

        Raises:
            CapabilityError: the weights are plastic, and the backend cannot read them.
            NetworkError: the projection does not exist.
        """
        chosen = changes.projection_of(self.network, projection)
        if chosen.rewiring is None:
            weights = self.read_weights(projection)
            pre, post, delay_ms = map(np.array, (chosen.pre_index, chosen.post_index, chosen.delay_ms))
            return Synapses(pre, post, weights, delay_ms)
        self.require_ready()
        with guarded(self, "read synapses"):
            return self._do_read_synapses(chosen)

    @final
    def read_rewirings(self, projection: str) -> Rewirings:
        """Return which synapses of a projection (by label) formed and vanished since time 0.

        Raises:
            NetworkError: the projection does not exist, or its synapses stay the same ones.
        """
        chosen = changes.rewired(changes.projection_of(self.network, projection))
        self.require_ready()
        with guarded(self, "read rewirings"):
            return self._do_read_rewirings(chosen)

    @final
    def set_weights(self, projection: str, weights: npt.ArrayLike) -> None:
        """Change the weights of a projection; spikes already in transit keep the old weights.

        Args:
            projection: the projection's label.
            weights: in PyNN's units: one number for all synapses, or one for each.

        Raises:
            CapabilityError: the backend cannot change them while it runs.
            NetworkError: the projection does not exist, or a weight is impossible.
        """
        self.require_ready()
        each = changes.new_weights(self.network, projection, weights)
        self._require_change(WEIGHTS)
        chosen = changes.lasting(changes.projection_of(self.network, projection))
        with guarded(self, "change weights"):
            self._do_set_weights(chosen, each)

    @final
    def set_synapse_parameters(self, projection: str, values: Mapping[str, npt.ArrayLike]) -> None:
        """Change parameters of synapses in equations, from the present time on.

        Until then their variables have followed the old ones; spikes in transit keep the share of the
        weight with which they were sent.

        Args:
            projection: the projection's label.
            values: new values by name in the units of the equations: one number for all synapses, or one
                for each.

        Raises:
            CapabilityError: the backend cannot change them while it runs.
            NetworkError: the projection or parameter does not exist, or a value is impossible.
        """
        self.require_ready()
        chosen, each = changes.synapse_parameters(self.network, projection, values)
        self._require_change(EQUATIONS)
        if each and chosen.size:
            with guarded(self, "change parameters"):
                self._do_set_synapse_parameters(chosen, each)

    @final
    def is_plastic(self, projection: str) -> bool:
        """Return whether the weights of a projection (by label) now change by themselves.

        Raises:
            NetworkError: the projection does not exist.
        """
        return changes.projection_of(self.network, projection).is_plastic and projection not in self._frozen

    @final
    def set_plastic(self, projection: str, plastic: bool) -> None:
        """Stop or continue the learning of a plastic projection.

        While it is stopped, no spike that reaches a synapse changes its weight, but all spikes leave their
        traces there. So a spike just before learning continues still pairs with one just after.

        Args:
            projection: the projection's label.
            plastic: whether it learns from now on; at time 0 it does.

        Raises:
            CapabilityError: the backend cannot stop it while it runs.
            NetworkError: the projection does not exist, or it is static.
        """
        self.require_ready()
        changes.learning(changes.projection_of(self.network, projection))
        self._require_change(PLASTICITY)
        if plastic is (projection in self._frozen):
            with guarded(self, "change plasticity"):
                self._freeze(self._frozen ^ {projection})

    def _freeze(self, labels: frozenset[str]) -> None:
        """Let these projections not learn, and all others learn."""
        for label in sorted(labels ^ self._frozen):
            self._do_set_plastic(changes.projection_of(self.network, label), label not in labels)
        self._frozen = labels

    @final
    def reward(self, projection: str, amount: float) -> None:
        """Add to the dopamine that a projection learns from, as a spike of that weight would at this time.

        Args:
            projection: the label of the projection whose weights change. All its target cells get
                the dopamine, so other synapses of these cells learn from it, too.
            amount: the change of dopamine; negative as a punishment.

        Raises:
            CapabilityError: the backend takes no rewards from outside.
            NetworkError: the projection does not learn from rewards, or the amount is not finite.
        """
        population = self._rewarded(projection, amount)
        if amount:
            with guarded(self, "reward"):
                self._do_reward(population, float(amount))

    @final
    def hold_reward(self, projection: str, value: float) -> None:
        """Set a value that adds to the dopamine that a projection learns from, and does not decay.

        It acts from this time on until the next call, or a reset. Without other rewards and without a
        baseline, weights follow the product of eligibility and this value.

        Args:
            projection: as for :meth:`reward`; the value applies to all its target cells.
            value: 0 at the beginning; negative as a punishment.

        Raises:
            CapabilityError, NetworkError: as for :meth:`reward`.
        """
        population = self._rewarded(projection, value)
        with guarded(self, "reward"):
            self._do_hold_reward(population, float(value))

    def _rewarded(self, projection: str, value: float) -> str:
        """Return the population whose dopamine a projection learns from; refuse impossible rewards."""
        self.require_ready()
        chosen = changes.rewarded(self.network, projection)
        if not self.capabilities.rewards:
            raise no_rewards(projection)
        if not is_number(value) or not isfinite(value):
            raise NetworkError(f"a reward of projection '{projection}' is {value!r:.60}; it must be finite")
        return chosen.post

    @final
    def read_synapse_state(self, projection: str, variable: str) -> FloatArray:
        """Return a state variable of synapses at the current time.

        Args:
            projection: the label of the projection.
            variable: of synapses with STDP that learn from rewards ``eligibility`` (units of the weight), or
                ``dopamine`` of the target of each synapse; a variable of synapses in equations, in its unit.

        Returns:
            In the order of the synapses, shape ``(n_synapses,)``.

        Raises:
            CapabilityError: the backend does not show it.
            NetworkError: the projection does not learn from rewards, or has no such variable.
        """
        self.require_ready()
        shown, chosen = self.capabilities.synapse_state, changes.projection_of(self.network, projection)
        if variable not in shown and (chosen.equations is None or not shown):
            raise not_shown(self, variable, shown)
        chosen = changes.with_synapse_state(self.network, projection, variable)
        with guarded(self, "read synapses"):
            return self._do_read_synapse_state(chosen, variable)

    # -- the sequence of one advance, identical for every backend

    @property
    def _seeds(self) -> Seeds:
        return Seeds(self._seed).child("brain")

    def _advance(self, t_ns: int) -> None:
        if self._grid_of_stops is not None:
            self._grid_of_stops.number_of(t_ns)
        began_ns = self._began_ns
        since_ms, until_ms = milliseconds(self.now_ns), milliseconds(t_ns)
        own_since_ms, own_until_ms = since_ms, until_ms  # in the time of the engine
        if began_ns:
            own_since_ms, own_until_ms = milliseconds(self.now_ns - began_ns), milliseconds(t_ns - began_ns)
        emitted = [train.emitted(own_since_ms, own_until_ms) for train in self._attached.trains]
        for ids, times_ms in emitted:
            if len(ids):
                self._do_fire(ids, times_ms)
        for source in self._attached.acting:
            events = source.events(since_ms, until_ms)
            if len(events):
                self._do_inject(events.earlier(milliseconds(began_ns), own_since_ms) if began_ns else events)
        self._run_under_currents(t_ns)
        spikes = Spikes.merged([self._do_take_spikes(), *(Spikes(ids, times) for ids, times in emitted)])
        if began_ns:
            spikes = spikes.later(milliseconds(began_ns), since_ms, until_ms)
        if len(spikes) and not (isfinite(spikes.times_ms.item(0)) and isfinite(spikes.times_ms.item(-1))):
            raise DivergedError(f"{type(self).__name__} returned a spike time that is not finite", t_ns=t_ns)
        for sink in self._attached.sinks:
            sink.receive(spikes, until_ms)

    def _run_under_currents(self, t_ns: int) -> None:
        """Run to ``t_ns``, halting at the points of the brain's grid that are nearest to changes of currents.

        State is recorded on the way.
        """
        grid_ns = self.capabilities.resolution_ns or 1
        at_ns, began_ns = self.now_ns, self._began_ns
        if not (self._attached.currents or self._attached.injected):
            if self._flowing:
                self._update_currents(at_ns)
            self._run_recording(at_ns, t_ns, grid_ns)
            return
        while at_ns < t_ns:
            seen_ns = at_ns + (grid_ns - 1) // 2  # a change up to then acts from this point on
            self._update_currents(seen_ns)
            changes_ns = [source.next_change_ns(seen_ns) for source in self._attached.currents]
            changes_ns.append(self._attached.injected.next_change_ns(seen_ns - began_ns) + began_ns)
            stop_ns = min(t_ns, nearest_ns(min(changes_ns), grid_ns))
            assert stop_ns > at_ns, f"a current changes at {stop_ns} ns, which is not after {at_ns} ns"
            self._run_recording(at_ns, stop_ns, grid_ns)
            at_ns = stop_ns

    def _run_recording(self, since_ns: int, until_ns: int, grid_ns: int) -> None:
        began_ns = self._began_ns
        if not self._attached.recorders:
            self._do_run_until(until_ns - began_ns)
            return
        traces = [recorder.due(since_ns, until_ns, grid_ns) for recorder in self._attached.recorders]
        samples = unset(sum(prod(trace.shape) for trace in traces))
        self._do_run_recording(until_ns - began_ns, [trace.earlier(began_ns) for trace in traces], samples)
        for recorder, trace, values in zip(
            self._attached.recorders, traces, split_samples(samples, traces), strict=True
        ):
            recorder.take(trace.times_ns, values)

    def _sample(self, recorder: StateRecorderPort, values: FloatArray) -> None:
        recorder.take(np.array([self.now_ns]), values[np.newaxis])

    def _stop_currents(self) -> None:
        self._currents, self._flowing = np.zeros(self.network.size), False

    def _update_currents(self, now_ns: int) -> None:
        total = self._attached.injected.total_na(now_ns - self._began_ns).copy()
        for source in self._attached.currents:
            np.add.at(total, source.neurons, source.current_na(now_ns))
        if (total != self._currents).any():
            self._currents, self._flowing = total, bool(total.any())
            self._do_set_current(total)

    def _reset(self) -> None:
        self._attached.reset(self._seeds)
        self._stop_currents()
        self._began_ns = 0
        self._freeze(frozenset())
        self._changed = {}
        self._do_reset(self._seed)
        for recorder in self._attached.recorders:
            self._sample(recorder, self._do_read_state(recorder.variable, recorder.neurons))

    def _reset_state(self) -> None:
        """Reset cells, weights and events in transit; source populations fire as they did from time 0."""
        self._attached.reset_trains(self._seeds)
        self._stop_currents()
        self._freeze(frozenset())
        self._changed = {}
        self._do_reset(self._seed)
        self._began_ns = self.now_ns

    def _save(self) -> object:
        self._require_snapshot()
        names, devices = self._attached.save()
        later = self._began_ns, self._frozen, dict(self._changed)
        return self._seed, self._currents, names, devices, self._do_save(), *later

    def _load(self, saved: Any) -> None:
        self._require_snapshot()
        seed, currents, names, devices, state, *later = saved  # version 0.1 stored no more
        self._attached.restore(names, devices)
        self._seed, self._currents, self._flowing = seed, currents, bool(currents.any())
        self._began_ns = later[0] if later else 0
        self._freeze(later[1] if len(later) > 1 else frozenset())  # its effect on the state now is lost
        self._changed = dict(later[2]) if len(later) > 2 else {}
        self._do_restore(state)

    def _require_change(self, what: str) -> None:
        if what not in self.capabilities.changes:
            raise no_change(self, what, self.capabilities.changes)

    def _require_snapshot(self) -> None:
        if not self.capabilities.snapshot:
            raise refusal(self, SNAPSHOTS)

    @property
    def _is_plain(self) -> bool:
        """Whether only its devices act on it now, so that it can advance together with others."""
        return self.state is State.READY and not (self._began_ns or self._flowing)

    @property
    def advances_together(self) -> bool:
        """Whether its backend advances many brains by one call."""
        return type(self)._engines is not Brain._engines

    def _engines(self) -> Engines:
        """Return the primitives for many brains of this type."""
        return Engines()

    # -- for backends: the operations that cannot be derived from others

    @abstractmethod
    def _do_run_until(self, t_ns: int) -> None:
        """Simulate to exactly ``t_ns``, which lies on the declared grid."""

    @abstractmethod
    def _do_take_spikes(self) -> Spikes:
        """Return and clear the new spikes in any order, without those that the core emits."""

    @abstractmethod
    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Emit spikes of source cells (global ids) at exact times within the next window."""

    @abstractmethod
    def _do_inject(self, events: SynapticEvents) -> None:
        """Deliver events to synapses of non-source cells; arrival times may lie beyond the next window."""

    @abstractmethod
    def _do_set_current(self, currents_na: FloatArray) -> None:
        """Set the constant current into each cell from now on, nA, shape ``(network.size,)``."""

    @abstractmethod
    def _do_reset(self, seed: int) -> None:
        """Return to the state right after opening."""

    def _emits(self, population: Population) -> bool:
        """Whether the simulator itself emits the spikes of a source population; else the core does."""
        return False

    def _do_run_recording(self, t_ns: int, traces: Sequence[Trace], samples: FloatArray) -> None:
        """Simulate to ``t_ns`` and store the samples of traces in order; by default, halt at each sample."""
        run_halting(t_ns, traces, samples, self._do_run_until, self._do_read_state)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        """Return a declared state variable of cells, none of which are source cells."""
        raise NotImplementedError(variable)

    def _do_set_parameters(self, change: ParameterChange) -> None:
        """Change parameters of cells, or of source cells that the simulator emits itself."""
        raise NotImplementedError(change.label)

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        """Return a copy of the current weights."""
        raise NotImplementedError(projection.label)

    def _do_read_synapses(self, projection: Projection) -> Synapses:
        """Return the current synapses of a projection whose synapses form and vanish."""
        raise NotImplementedError(projection.label)

    def _do_read_rewirings(self, projection: Projection) -> Rewirings:
        """Return which synapses of a projection formed and vanished since time 0, in this order."""
        raise NotImplementedError(projection.label)

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        """Change the weights, shape ``(n_synapses,)``."""
        raise NotImplementedError(projection.label)

    def _do_set_synapse_parameters(self, projection: Projection, values: Mapping[str, FloatArray]) -> None:
        """Change parameters of synapses in equations, each of shape ``(n_synapses,)``."""
        raise NotImplementedError(projection.label)

    def _do_set_plastic(self, projection: Projection, plastic: bool) -> None:
        """Stop or continue the learning of a plastic projection; a reset or restore is not to change this."""
        raise NotImplementedError(projection.label)

    def _do_reward(self, population: str, amount: float) -> None:
        """Add to the dopamine of all cells of a population now."""
        raise NotImplementedError(population)

    def _do_hold_reward(self, population: str, value: float) -> None:
        """Let a value add to the dopamine of all cells of a population from now on, instead of the last."""
        raise NotImplementedError(population)

    def _do_read_synapse_state(self, projection: Projection, variable: str) -> FloatArray:
        """Return a state variable of synapses in its unit, shape ``(n_synapses,)``."""
        raise NotImplementedError(variable)

    def _do_save(self) -> object:
        """Return the complete state as an object that can be pickled."""
        raise NotImplementedError

    def _do_restore(self, saved: object) -> None:
        """Restore a state from :meth:`_do_save`."""
        raise NotImplementedError
