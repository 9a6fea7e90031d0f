"""A network in the event-driven engine."""

from __future__ import annotations

from math import inf, nextafter
from typing import Any, Final

import numpy as np

from nrp_brain_event.backend import EventOptions
from nrp_brain_event.cell_types import CELL_TYPES
from nrp_brain_event.engine import build_engine, changing, enlarged
from nrp_brain_event.kernels import READABLE, emit, inject, read, run, set_currents
from nrp_brain_event.records import DIVERGED, FULL, Engine
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.network import FloatArray, IntArray, Network
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError, DivergedError

_PATIENCE_MS: Final = 20.0


class EventBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`."""

    def __init__(
        self, network: Network, seed: int, capabilities: BrainCapabilities, options: EventOptions
    ) -> None:
        identity = f"event:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._initial = build_engine(network, options.tolerance)
        self._engine = self._fresh()

    def _do_run_until(self, t_ns: int) -> None:
        until_ms, stop_ms = milliseconds(t_ns), float(self._engine.clock["now"][0])
        while stop_ms < until_ms:  # compiled code cannot be interrupted, so it comes back now and then
            stop_ms = min(stop_ms + _PATIENCE_MS, until_ms)
            while (status := run(self._engine, stop_ms, nextafter(stop_ms, inf))) == FULL:
                self._engine = enlarged(self._engine)
            if status == DIVERGED:
                label, index = self.network.label_of(int(self._engine.clock["failed"][0]))
                raise DivergedError(
                    f"cell {index} of population '{label}' cannot be integrated any further; look for "
                    "extreme weights or currents",
                    t_ns=t_ns,
                )

    def _do_take_spikes(self) -> Spikes:
        clock = self._engine.clock
        taken = self._engine.spikes[: int(clock["n_spikes"][0])].copy()
        clock["n_spikes"] = 0
        return Spikes(taken["id"], taken["time"])

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        done = 0
        while (done := emit(self._engine, neurons, times_ms, done)) < len(neurons):
            self._engine = enlarged(self._engine)

    def _do_inject(self, events: SynapticEvents) -> None:
        neurons, times_ms, weights = events.neurons, events.times_ms, events.weights
        inhibitory, done = int(events.receptor == "inhibitory"), 0
        while (done := inject(self._engine, neurons, times_ms, weights, inhibitory, done)) < len(events):
            self._engine = enlarged(self._engine)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        set_currents(self._engine, currents_na)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        self._require_variable(variable, neurons)
        values = np.empty(len(neurons))
        read(self._engine, neurons, READABLE.index(variable), values)
        return values

    def _do_reset(self, seed: int) -> None:
        self._engine = self._fresh()

    def _do_save(self) -> object:
        return changing(self._engine)

    def _do_restore(self, saved: Any) -> None:
        self._engine = self._initial._replace(**saved)

    def _do_close(self) -> None:
        del self._engine, self._initial

    def _fresh(self) -> Engine:
        return self._initial._replace(**changing(self._initial))

    def _require_variable(self, variable: str, neurons: IntArray) -> None:
        for label, first in self.network.offsets.items():
            population = self.network.populations[label]
            kind = CELL_TYPES.get(population.cell_type)
            shown = kind is not None and variable in kind.state_variables
            if not shown and ((neurons >= first) & (neurons < first + population.size)).any():
                raise CapabilityError(f"the cells of population '{label}' have no '{variable}'")
