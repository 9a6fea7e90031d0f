"""A network in the event-driven engine."""

from __future__ import annotations

from math import inf, nextafter
from typing import Any

import numpy as np
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.network import FloatArray, IntArray, Network
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError, DivergedError

from nrp_brain_event.backend import EventOptions
from nrp_brain_event.cell_types import CELL_TYPES
from nrp_brain_event.engine import build_engine, copied, with_room
from nrp_brain_event.kernels import emit, inject, read_synapses, read_voltages, run, set_currents
from nrp_brain_event.records import DIVERGED, FULL, Engine
from nrp_brain_event.runge_kutta import state_at


class EventBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`."""

    def __init__(
        self, network: Network, seed: int, capabilities: BrainCapabilities, options: EventOptions
    ) -> None:
        identity = f"event:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._initial = build_engine(network, options.tolerance)
        self._engine = copied(self._initial)

    def _do_run_until(self, t_ns: int) -> None:
        until = milliseconds(t_ns)
        while (status := run(self._engine, until, nextafter(until, inf))) == FULL:
            self._make_room()
        if status == DIVERGED:
            label, index = self.network.label_of(int(self._engine.clock[0].failed))
            raise DivergedError(
                f"cell {index} of population '{label}' cannot be integrated further; "
                "look for extreme weights or currents", t_ns=t_ns,
            )  # fmt: skip

    def _do_take_spikes(self) -> Spikes:
        clock = self._engine.clock
        taken = self._engine.spikes[: int(clock["n_spikes"][0])].copy()
        clock["n_spikes"] = 0
        return Spikes(taken["id"], taken["time"])

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        done = 0
        while (done := emit(self._engine, neurons, times_ms, done)) < len(neurons):
            self._make_room()

    def _do_inject(self, events: SynapticEvents) -> None:
        receptor, done = int(events.receptor == "inhibitory"), 0
        while True:
            engine = self._engine
            done = inject(
                engine.row_of, engine.clock, engine.event_slots, engine.events,
                events.neurons, events.times_ms, events.weights, receptor, done,
            )  # fmt: skip
            if done == len(events):
                return
            self._make_room()

    def _do_set_current(self, currents_na: FloatArray) -> None:
        set_currents(self._engine, currents_na, milliseconds(self._now_ns))

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        self._require_variable(variable, neurons)
        engine, now_ms = self._engine, milliseconds(self._now_ns)
        rows, values = engine.row_of[neurons], np.empty(len(neurons))
        if variable == "v":
            read_voltages(engine.cells, rows, now_ms, values)
        elif variable in ("gsyn_exc", "gsyn_inh"):
            read_synapses(engine.cells, rows, int(variable == "gsyn_inh"), now_ms, values)
        else:  # w, u: the second of an integrated membrane
            cells = [engine.cells[row] for row in rows]
            values[:] = [state_at(cell, 1, now_ms) for cell in cells]
        return values

    def _do_reset(self, seed: int) -> None:
        self._engine = copied(self._initial)

    def _do_save(self) -> object:
        return tuple(copied(self._engine))

    def _do_restore(self, saved: Any) -> None:
        self._engine = copied(Engine(*saved))

    def _do_close(self) -> None:
        del self._engine, self._initial

    def _make_room(self) -> None:
        engine = self._engine
        self._engine = with_room(engine, len(engine.events) + 1, len(engine.spikes) + 1)

    def _require_variable(self, variable: str, neurons: IntArray) -> None:
        for label in {self.network.label_of(int(neuron))[0] for neuron in neurons}:
            kind = CELL_TYPES.get(self.network.populations[label].cell_type)
            if kind is None or variable not in kind.state_variables:
                raise CapabilityError(f"the cells of population '{label}' have no '{variable}'")
