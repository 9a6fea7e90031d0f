"""Brian2 through pyNN.brian2. Importing this loads it."""

from __future__ import annotations

import gc
from typing import Any, Final

import brian2
import numpy as np
import pyNN.brian2 as sim
from nrp_core.brain import (
    TSODYKS_MARKRAM,
    FloatArray,
    IndexArray,
    IntArray,
    Population,
    Projection,
    Spikes,
    SynapticEvents,
    no_variable,
)
from nrp_core.errors import CapabilityError
from pyNN.connectors import Connector

from nrp_brain_pynn.brian2_models import PUT_RIGHT, TsodyksMarkramSynapse
from nrp_brain_pynn.late_weights import LateWeightsDriver
from nrp_brain_pynn.short_term import decay_ms
from nrp_brain_pynn.stepping import SteppedRun

_SOLVED: Final = ("IF_curr_exp", "IF_curr_alpha")
"""Cells whose equations Brian2 solves exactly."""
_UNITS: Final = {"v": 1e-3, "u": 1.0, "w": 1e-9, "gsyn_exc": 1e-6, "gsyn_inh": 1e-6}
_WEIGHT_UNITS: Final = {"v": 1e-3, "i": 1e-9, "y": 1e-9, "g": 1e-6}
_NANO: Final = 1e-9
_NO_TIME_MS: Final = 1e-6


class SourceGroup(brian2.NeuronGroup):  # type: ignore[misc]
    """Cells that emit spikes in given steps."""

    def __init__(self, size: int, equations: Any, **_: Any) -> None:
        clock = sim.simulator.state.network.clock
        super().__init__(size, "due : boolean", threshold="due", reset="due = False", clock=clock)

    def initialize(self) -> None:
        """Do nothing, because it has no state."""


class SourceType(sim.SpikeSourceArray):  # type: ignore[misc]
    """PyNN's description of :class:`SourceGroup`."""

    brian2_model = SourceGroup


class AtOnce(Connector):  # type: ignore[misc]
    """Creates all synapses in one call; PyNN gives all synapses between two cells the values of the last."""

    def __init__(self, pre: IndexArray, post: IndexArray, columns: dict[str, FloatArray]) -> None:
        super().__init__(safe=False)
        self._pre, self._post, self._columns = pre, post, columns

    def connect(self, projection: Any) -> None:
        """See PyNN."""
        synapses = projection._brian2_synapses[0][0]
        synapses.connect(i=self._pre, j=self._post)
        unit = projection.synapse_type.translations["weight"]["forward_transform"]
        synapses.weight = unit(weight=self._columns["weight"])
        synapses.delay = self._columns["delay"] * brian2.ms
        for name in ("tau_rec", "tau_facil", "tau_syn"):
            if name in self._columns:
                setattr(synapses, name, np.maximum(self._columns[name], _NO_TIME_MS) * brian2.ms)
        if "U" in self._columns:
            synapses.U = self._columns["U"]
        projection._n_connections += len(self._pre)


class Brian2Driver(LateWeightsDriver):
    """See :class:`~nrp_brain_pynn.driver.Driver`. One run of Brian2 lasts from the first step to the last.

    Results of Brian2 in the step that begins at ``t`` are those at its end, ``t + dt``.
    """

    sim = sim

    def _set_up(self, longest_delay_ms: float) -> None:
        brian2.prefs.codegen.target = "cython" if self.options.compiled else "numpy"
        brian2.BrianLogger.suppress_name("method_choice")
        sim.setup(timestep=self.grid.step_ms, min_delay=self.grid.step_ms)
        self._due: dict[int, list[tuple[Any, Any]]] = {}
        self._arriving: dict[int, list[tuple[Any, IntArray, FloatArray, Any]]] = {}
        self._spikes: list[tuple[int, IntArray]] = []

    def _sources(self, population: Population) -> Any:
        return sim.Population(population.size, SourceType(), label=population.label)

    def _cells(self, population: Population) -> Any:
        parameters = population.parameters
        for name in ("tau_syn_E", "tau_syn_I") if population.cell_type in _SOLVED else ():
            if (parameters["tau_m"] == parameters[name]).any():
                raise CapabilityError(
                    f"population '{population.label}': Brian2's solution of {population.cell_type} divides "
                    f"by the difference of tau_m and {name}, which are equal; change one slightly"
                )
        return super()._cells(population)

    def _kind(self, cell_type: str) -> Any:
        return PUT_RIGHT[cell_type]

    def _connector(self, projection: Projection, columns: dict[str, FloatArray]) -> Any:
        if projection.synapse_type == TSODYKS_MARKRAM:
            columns = columns | {"tau_syn": decay_ms(self.network, projection)}
        return AtOnce(projection.pre_index, projection.post_index, columns)

    def _short_term(self) -> Any:
        return TsodyksMarkramSynapse()

    def _begin(self) -> None:
        super()._begin()
        self._watched = []
        for label in self.cell_labels:
            group, ids = self.populations[label].brian2_group, self.network.ids_of(label)
            self._watched.append((group.variables["_spikespace"], ids))
        network, clock = sim.simulator.state.network, sim.simulator.state.network.clock
        for operation, slot in ((self._emit, "start"), (self._arrive, "synapses"), (self._note, "end")):
            network.add(brian2.NetworkOperation(_told_step(operation, clock), when=slot, clock=clock))
        self._run = SteppedRun(network, clock)

    # -- operations in each step, in Brian2's thread

    def _emit(self, step: int) -> None:
        for flags, index in self._due.pop(step, ()):
            flags[index] = True

    def _arrive(self, step: int) -> None:
        for variable, index, amounts, unlocked in self._arriving.pop(step, ()):
            if unlocked is not None:  # Brian2 ignores input to a refractory membrane
                amounts = amounts * unlocked.get_value()[index]
            np.add.at(variable.get_value(), index, amounts)

    def _note(self, step: int) -> None:
        for space, ids in self._watched:
            found = space.get_value()
            if found[-1]:
                self._spikes.append((step + 1, ids[found[: found[-1]]]))

    # -- between steps

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        steps = self.grid.first_at(times_ms) - 1
        for label, index, which in self.by_population(neurons):
            flags = self.populations[label].brian2_group.variables["due"].get_value()
            taken: set[tuple[int, int]] = set()
            for cell, step in zip(index.tolist(), steps[which].tolist(), strict=True):
                while (cell, step) in taken:  # one spike per step: the next one waits
                    step += 1
                taken.add((cell, step))
                self._due.setdefault(step, []).append((flags, cell))

    def inject(self, events: SynapticEvents) -> None:
        steps = np.maximum(self.grid.first_at(events.times_ms) - 1, self._run.step)
        for label, index, which in self.by_population(events.neurons):
            population = self.populations[label]
            name = population.celltype.post_synaptic_variables[events.receptor]
            variable = population.brian2_group.variables[name]
            scale = 1e-6 if population.celltype.conductance_based else _WEIGHT_UNITS[name[0]]
            amounts = events.weights[which] * scale
            when = steps[which]
            for step in np.unique(when).tolist():
                now = when == step
                arrival = variable, index[now], amounts[now], variable.conditional_write
                self._arriving.setdefault(step, []).append(arrival)

    def _pass(self, step: int) -> None:
        self._run.until(step)

    def _finish(self, step: int) -> None:
        self._run.until(step)

    def _write(self, projection: Projection, index: IntArray, weights: FloatArray) -> None:
        made = self.projections[projection.label]
        unit = made.synapse_type.translations["weight"]["forward_transform"]
        held = made._brian2_synapses[0][0].variables["weight"].get_value()
        held[index] = np.asarray(unit(weight=weights))

    def take_spikes(self) -> Spikes:
        spikes, self._spikes = self._spikes, []
        if not spikes:
            return Spikes()
        steps = np.repeat([step for step, _ in spikes], [len(ids) for _, ids in spikes])
        return Spikes(np.concatenate([ids for _, ids in spikes]), self.grid.time_ms(steps))

    def _hold(self, label: str, index: IntArray, currents_na: FloatArray) -> None:
        held = self.populations[label].brian2_group.variables["i_offset"].get_value()
        held[index] = currents_na * _NANO

    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        values = np.zeros(len(neurons))
        for label, index, which in self.by_population(neurons):
            population = self.populations[label]
            known = getattr(population.celltype, "state_variable_translations", {})
            if variable not in known:
                raise no_variable(label, variable)
            name = known[variable]["translated_name"]
            values[which] = population.brian2_group.variables[name].get_value()[index] / _UNITS[variable]
        return values

    def close(self) -> None:
        self._run.stop()
        self.populations.clear()
        self._watched.clear()
        sim.simulator.state.clear()
        gc.collect()  # objects of equal names have equal code, which is compiled already


def _told_step(operation: Any, clock: Any) -> Any:
    """Return a function without arguments, for Brian2, that passes the step to an operation."""
    number = clock.variables["timestep"]

    def run() -> None:
        operation(int(number.get_value()[0]))

    return run
