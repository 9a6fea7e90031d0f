"""A network in the event-driven engine."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import inf, nextafter
from typing import Any, Final

import numpy as np

from nrp_brain_event.cell_types import diverged, require_variable
from nrp_brain_event.connections import places_of
from nrp_brain_event.engine import build_engine, changing, enlarged
from nrp_brain_event.equations.synapses import keep_kernels
from nrp_brain_event.handles import handle
from nrp_brain_event.kernels import READABLE, emit, inject, read, run, set_currents, spread
from nrp_brain_event.live import change_parameters, change_weights, weights_now
from nrp_brain_event.options import EventOptions
from nrp_brain_event.random_numbers import begin_streams
from nrp_brain_event.records import DIVERGED, FULL, EngineArrays
from nrp_brain_event.traces import planned, run_reading
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.changes import ParameterChange
from nrp_core.brain.devices.state_recorder import Trace
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS, milliseconds

_PATIENCE_NS: Final = 20_000_000
_PATIENCE_MS: Final = milliseconds(_PATIENCE_NS)


class EventBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`."""

    def __init__(
        self, network: Network, seed: int, capabilities: BrainCapabilities, options: EventOptions
    ) -> None:
        identity = f"event:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._initial = build_engine(network, options.tolerance)
        self._take(self._fresh())

    def _take(self, engine: EngineArrays) -> None:
        """Continue with an engine."""
        self._engine, self._places = handle(engine)

    def _do_run_until(self, t_ns: int) -> None:
        until_ms, stop_ms = milliseconds(t_ns), float(self._engine.clock["now"][0])
        while stop_ms < until_ms:  # compiled code cannot be interrupted, so it returns from time to time
            stop_ms = min(stop_ms + _PATIENCE_MS, until_ms)
            while (status := run(self._places, stop_ms, nextafter(stop_ms, inf))) == FULL:
                self._take(enlarged(self._engine))
            if status == DIVERGED:
                raise diverged(self.network, int(self._engine.clock["failed"][0]), t_ns)

    def _do_run_recording(self, t_ns: int, traces: Sequence[Trace], samples: FloatArray) -> None:
        for trace in traces:
            require_variable(self.network, trace.variable, trace.neurons)
        now_ns = round(float(self._engine.clock["now"][0]) * NS_PER_MS)
        plan = planned(traces, now_ns, t_ns, _PATIENCE_NS)
        while (done := int(plan.done[0])) < len(plan.stops):
            until_ms = plan.stops[done] + _PATIENCE_MS
            last = max(done + 1, int(np.searchsorted(plan.stops, until_ms)))
            status = run_reading(self._places, *plan, last, samples)
            if status == FULL:
                self._take(enlarged(self._engine))
            elif status == DIVERGED:
                raise diverged(self.network, int(self._engine.clock["failed"][0]), t_ns)

    def _do_take_spikes(self) -> Spikes:
        clock = self._engine.clock
        taken = self._engine.spikes[: int(clock["n_spikes"][0])].copy()
        clock["n_spikes"] = 0
        return Spikes(taken["id"], taken["time"])

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        done = 0
        while (done := emit(self._places, neurons, times_ms, done)) < len(neurons):
            self._take(enlarged(self._engine))

    def _do_inject(self, events: SynapticEvents) -> None:
        neurons, times_ms, weights = events.neurons, events.times_ms, events.weights
        inhibitory, done = int(events.receptor == "inhibitory"), 0
        while (done := inject(self._places, neurons, times_ms, weights, inhibitory, done)) < len(neurons):
            self._take(enlarged(self._engine))

    def _do_set_current(self, currents_na: FloatArray) -> None:
        set_currents(self._places, currents_na)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        require_variable(self.network, variable, neurons)
        values = np.empty(len(neurons))
        read(self._places, neurons, READABLE.index(variable), values)
        return values

    def _do_set_parameters(self, change: ParameterChange) -> None:
        change_parameters(self._engine, self.network, change)

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return weights_now(self._engine, projection, self._rows_of[projection.label])

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        if self._engine.weight is self._initial.weight:
            self._take(self._engine._replace(weight=self._engine.weight.copy()))
        while not spread(self._places):
            self._take(enlarged(self._engine))
        change_weights(self._engine, projection, self._rows_of[projection.label], weights)

    @cached_property
    def _rows_of(self) -> dict[str, IntArray]:
        return places_of(self.network, self._initial.row_of)

    def _do_reset(self, seed: int) -> None:
        self._take(self._fresh())

    def _do_save(self) -> object:
        return changing(self._engine, self._initial)

    def _do_restore(self, saved: Any) -> None:
        self._take(self._initial._replace(**saved))
        keep_kernels(self._engine.short_term, self._initial.short_term)

    def _do_close(self) -> None:
        del self._engine, self._places, self._initial

    def _fresh(self) -> EngineArrays:
        engine = self._initial._replace(**changing(self._initial))
        if len(engine.short_term):
            begin_streams(engine.short_term, self._seeds.integer("synapses", 62))
        return engine
