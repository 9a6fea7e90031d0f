"""A network in the event-driven engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import inf, nextafter
from typing import Any, Final

import numpy as np

from nrp_brain_event.cell_types import diverged, require_variable
from nrp_brain_event.connections import begin_plastic, places_of_plastic, places_of_static
from nrp_brain_event.engine import StoredSpikes, changing, enlarged, require_room
from nrp_brain_event.equation_synapses import (
    change_rules,
    change_shares,
    keep_addresses,
    keep_kernels,
    share_state,
)
from nrp_brain_event.handles import handle
from nrp_brain_event.kernels import READABLE, emit, inject, read, run, set_currents, spread
from nrp_brain_event.live import (
    bring_to_present,
    change_parameters,
    change_plasticity,
    change_weights,
    freeze,
    planned,
    plastic_now,
    require_slow,
    run_reading,
)
from nrp_brain_event.options import EventOptions
from nrp_brain_event.random_numbers import begin_streams
from nrp_brain_event.records import CONSTANT, DIVERGED, DONE, FULL, Array, EngineArrays
from nrp_brain_event.rewards import Tables, require_weights, rewards_of, wired
from nrp_brain_event.shared_start import start_of
from nrp_brain_event.together import EventEngines
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import COMPILED
from nrp_core._support.signals import end_if_asked
from nrp_core.brain.devices.sinks import Trace
from nrp_core.brain.engines import Engines
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import from_milliseconds, milliseconds
from nrp_core.network.changes import DOPAMINE, ParameterChange
from nrp_core.network.data import Network, Projection

_PATIENCE_NS: Final = 20_000_000
_PATIENCE_MS: Final = milliseconds(_PATIENCE_NS)
_REWARDS: Final = "rewards"
"""The name of their state in a snapshot."""
_AHEAD_MS: Final = 4.0
"""For how long spikes of sources are emitted at once onto plastic synapses."""


class EventBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`."""

    def __init__(
        self, network: Network, seed: int, capabilities: BrainCapabilities, options: EventOptions
    ) -> None:
        identity = f"event:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._ahead: list[tuple[IntArray, FloatArray]] = []
        self._wired = wired(network)
        quadrature = options.integration == "quadrature"
        self._start = start_of(self._wired, options.tolerance, quadrature=quadrature)
        self._initial = engine = self._start.engine
        self._rewards, more = rewards_of(
            network, engine.row_of, None, engine._asdict(), lambda: self._plastic
        )
        self._initial = self._engine = engine._replace(**more)
        self._take_copies(changing(self._initial))
        self._begin_streams()

    def _take(self, engine: EngineArrays) -> None:
        """Continue with an engine."""
        self._engine, self._places = handle(engine)
        self._now_ms, self._stored = engine.clock["now"], StoredSpikes(engine.clock, engine.spikes)

    @property
    def _is_plain(self) -> bool:
        return super()._is_plain and not self._ahead

    def _engines(self) -> Engines:
        return EventEngines() if COMPILED and self._rewards is None else super()._engines()

    def _do_run_until(self, t_ns: int) -> None:
        if self._rewards is None:
            self._run_to(t_ns)
        else:
            since_ns = from_milliseconds(self._now_ms.item(0))
            self._rewards.run(
                since_ns, t_ns, self._run_to, lambda n: self._stored.since(n), self._synapses
            )  # fmt: skip

    def _synapses(self) -> Tables:
        now = self._engine
        return Tables(now.cells, now.plastic, now.slow, now.rules, now.events)

    def _run_to(self, t_ns: int) -> None:
        until_ms, stop_ms = milliseconds(t_ns), self._now_ms.item(0)
        while stop_ms < until_ms:  # compiled code cannot be interrupted, so it returns from time to time
            end_if_asked()
            stop_ms = min(stop_ms + (_AHEAD_MS if self._ahead else _PATIENCE_MS), until_ms)
            if self._ahead:
                self._emit_until(stop_ms)
            while (status := run(self._places, stop_ms, nextafter(stop_ms, inf))) != DONE:
                self._go_on(status, t_ns)

    def _go_on(self, status: int, t_ns: int) -> None:
        """Prepare to continue after compiled code has returned early."""
        end_if_asked()
        if status == FULL:
            self._enlarge()
        elif status == DIVERGED:
            raise diverged(self.network, int(self._engine.clock["failed"][0]), t_ns)

    def _enlarge(self) -> None:
        """Make room for more events or spikes.

        Raises:
            NetworkError: they would take too much memory.
        """
        require_room(self._engine, self.network)
        self._take(enlarged(self._engine))

    def _do_run_recording(self, t_ns: int, traces: Sequence[Trace], samples: FloatArray) -> None:
        for trace in traces:
            require_variable(self.network, trace.variable, trace.neurons)
        if self._rewards is not None:
            super()._do_run_recording(t_ns, traces, samples)
            return
        now_ns = from_milliseconds(self._now_ms.item(0))
        plan = planned(traces, now_ns, t_ns, _PATIENCE_NS)
        while (done := int(plan.done[0])) < len(plan.stops):
            until_ms = plan.stops[done] + (_AHEAD_MS if self._ahead else _PATIENCE_MS)
            last = max(done + 1, int(np.searchsorted(plan.stops, until_ms)))
            if self._ahead:
                self._emit_until(plan.stops[last - 1])
            status = run_reading(self._places, *plan, last, samples)
            if status != DONE:
                self._go_on(status, t_ns)

    def _do_take_spikes(self) -> Spikes:
        if self._rewards is not None:
            self._rewards.n_heard = 0
        return self._stored.take()

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        if self._rewards is not None:
            self._rewards.fire(neurons, times_ms)
        if not len(self._engine.plastic) or times_ms.max(initial=0.0) <= self._now_ms.item(0) + _AHEAD_MS:
            self._emit(neurons, times_ms)
        else:
            self._ahead.append((neurons, times_ms))

    def _emit_until(self, stop_ms: float) -> None:
        """Emit the spikes of sources before a halt that have not been emitted yet.

        Each takes room for every plastic synapse that it passes, so those of a long run come in parts.
        """
        later = []
        for neurons, times_ms in self._ahead:
            due = times_ms <= stop_ms
            self._emit(neurons[due], times_ms[due])
            if not due.all():
                later.append((neurons[~due], times_ms[~due]))
        self._ahead = later

    def _emit(self, neurons: IntArray, times_ms: FloatArray) -> None:
        done = 0
        while (done := emit(self._places, neurons, times_ms, done)) < len(neurons):
            self._enlarge()

    def _do_inject(self, events: SynapticEvents) -> None:
        neurons, times_ms, weights = events.neurons, events.times_ms, events.weights
        inhibitory, done = int(events.receptor == "inhibitory"), 0
        while (done := inject(self._places, neurons, times_ms, weights, inhibitory, done)) < len(neurons):
            self._enlarge()

    def _do_set_current(self, currents_na: FloatArray) -> None:
        set_currents(self._places, currents_na)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        require_variable(self.network, variable, neurons)
        values = np.empty(len(neurons))
        read(self._places, neurons, READABLE.index(variable), values)
        return values

    def _do_set_parameters(self, change: ParameterChange) -> None:
        self._take(change_parameters(self._engine, self.network, change))

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        if projection.neuromodulation is not None:
            return projection.weight.copy()
        if not projection.is_plastic:
            weights: FloatArray = self._engine.weight[self._rows_of(projection)]
            return weights
        return plastic_now(self._engine, self._rows_of(projection)).weights

    def _do_read_synapse_state(self, projection: Projection, variable: str) -> FloatArray:
        if variable == DOPAMINE and self._rewards is not None and self._rewards.has(projection):
            return self._rewards.dopamine(projection, self._now_ms.item(0))
        if not projection.is_plastic:
            rows = self._engine.dynamics[self._rows_of(projection)]
            now_ms = np.full(len(rows), self._now_ms.item(0))
            return share_state(self._engine.short_term[rows], projection, variable, now_ms)
        return plastic_now(self._engine, self._rows_of(projection)).variable(projection, variable)

    def _do_reward(self, population: str, amount: float) -> None:
        assert self._rewards is not None
        self._rewards.reward(population, amount, self._now_ms.item(0))

    def _do_hold_reward(self, population: str, value: float) -> None:
        assert self._rewards is not None
        self._rewards.hold(population, value, self._now_ms.item(0))

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        require_weights(projection)
        if self._engine.weight is self._initial.weight:
            self._take(self._engine._replace(weight=self._engine.weight.copy()))
        while not spread(self._places):
            self._take(enlarged(self._engine))
        change_weights(self._engine, projection, self._rows_of(projection), weights)

    def _do_set_synapse_parameters(self, projection: Projection, values: Mapping[str, FloatArray]) -> None:
        rows = self._rows_of(projection)
        if not projection.is_plastic:
            own = self._engine.dynamics[rows]
            table = self._engine.short_term[own]
            change_shares(table, projection, values, np.full(len(own), self._now_ms.item(0)))
            self._engine.short_term[own] = table
            return
        if self._rewards is not None:
            self._rewards.require_same_decay(projection, values, self._engine.rules)
        bring_to_present(self._engine)
        rules = self._engine.rules.copy()
        change_rules(rules, self._engine.plastic["rule"][rows], projection, values)
        self._take(self._engine._replace(rules=rules))

    def _do_set_plastic(self, projection: Projection, plastic: bool) -> None:
        rows = self._rows_of(projection)
        change_plasticity(self._engine, rows, plastic)
        freeze(self._initial.rules, self._engine.plastic["rule"][rows], not plastic)

    def _rows_of(self, projection: Projection) -> Array:
        return (self._plastic if projection.is_plastic else self._static)[projection.label]

    @cached_property
    def _plastic(self) -> dict[str, Array]:
        return places_of_plastic(self._wired, self._initial.row_of)[1]

    @cached_property
    def _static(self) -> dict[str, Array]:
        return places_of_static(self._wired)

    def _do_reset(self, seed: int) -> None:
        self._ahead.clear()
        if self._rewards is not None:
            self._rewards.begin()
        if len(self._engine.plastic):
            begin_plastic(self._wired, self._engine.plastic, self._engine.slow, self._plastic)
        self._return_to({**changing(self._initial), **self._without_copy()})
        self._begin_streams()

    def _without_copy(self) -> dict[str, Array]:
        """Return the arrays whose initial state is not kept, since they can be large."""
        return {"plastic": self._engine.plastic, "slow": self._engine.slow}

    def _do_save(self) -> object:
        state = changing(self._engine, self._initial)
        saved: dict[str, object] = {name: array.tobytes() for name, array in state.items()}
        return saved if self._rewards is None else saved | {_REWARDS: self._rewards.save()}

    def _do_restore(self, saved: Any) -> None:
        initial = self._initial._asdict()
        if self._rewards is not None:
            self._rewards.restore(saved[_REWARDS])
        require_slow(saved, self._engine.plastic)
        self._return_to(
            {
                name: np.frombuffer(state, initial[name].dtype) if isinstance(state, bytes) else state
                for name, state in saved.items()  # version 0.1 saved arrays
                if name != _REWARDS
            }
        )
        keep_kernels(self._engine.short_term, self._initial.short_term)
        keep_addresses(self._engine.rules, self._initial.rules)

    def _return_to(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that differ from the initial ones; they are copied."""
        now = self._engine._asdict()
        if all(
            name in state and array.shape == state[name].shape
            if name not in CONSTANT
            else name not in state and array is getattr(self._initial, name)
            for name, array in now.items()
        ):
            for name, array in state.items():  # as bytes: NumPy assigns structures field by field
                if array is not now[name]:
                    now[name].view(np.uint8)[:] = array.view(np.uint8)
        else:
            self._take_copies(state)

    def _take_copies(self, state: Mapping[str, Array]) -> None:
        """Continue with new arrays."""
        kept = {*map(id, self._without_copy().values())}
        copies = {name: array if id(array) in kept else array.copy() for name, array in state.items()}
        self._take(self._initial._replace(**copies))
        self._initial = self._initial._replace(**self._without_copy())

    def _begin_streams(self) -> None:
        if len(self._engine.short_term):
            begin_streams(self._engine.short_term, self._seeds.integer("synapses", 62))

    def _do_close(self) -> None:
        del self._engine, self._places, self._initial, self._start, self._now_ms, self._stored
