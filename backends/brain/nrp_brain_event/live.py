"""Changes of the engine between two runs: parameters of cells, weights of synapses.

State variables that are recorded while the exact mode runs, inside compiled code.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from nrp_brain_event.cell_types import TIME_CONSTANTS
from nrp_brain_event.cells import with_parameters
from nrp_brain_event.equation_synapses import state_of
from nrp_brain_event.kernels import READABLE, begin_anew, read, run
from nrp_brain_event.linear import modes_of
from nrp_brain_event.records import DONE, FROZEN, JUMP, Array, CellParameters, EngineArrays, Modes
from nrp_brain_event.synapse_kernels import bring_up_to, synapses_at
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.brain.devices.sinks import Trace
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import SnapshotError
from nrp_core.network.changes import ParameterChange
from nrp_core.network.data import Network, Projection


class Plan(NamedTuple):
    """A run that halts where samples are taken.

    Args:
        stops, ends: times (ms), and the next number after each, see :func:`nrp_brain_event.kernels.run`.
        readings: samples in the order of their times: index of the stop, variable, first neuron, number of
            neurons, place of the sample; shape ``(n, 5)``.
        neurons: global ids, grouped by trace.
        done: number of stops and of readings that have passed, shape ``(2,)``.
    """

    stops: FloatArray
    ends: FloatArray
    readings: IntArray
    neurons: IntArray
    done: IntArray


def planned(traces: Sequence[Trace], since_ns: int, until_ns: int, patience_ns: int) -> Plan:
    """Return a run with the samples of traces, which also halts at least every ``patience_ns``."""
    halts = np.append(np.arange(since_ns + patience_ns, until_ns, patience_ns), until_ns)
    stops_ns = np.concatenate([halts, *(trace.times_ns for trace in traces)])
    stops_ns = stops_ns[:1] if (stops_ns == until_ns).all() else np.unique(stops_ns)  # one in a short run
    rows, first, place = [], 0, 0
    for trace in traces:
        n, m = trace.shape
        own = np.empty((n, 5), np.int64)
        own[:, 0] = np.searchsorted(stops_ns, trace.times_ns)
        own[:, 1:4] = READABLE.index(trace.variable), first, m
        own[:, 4] = place + m * np.arange(n)
        rows.append(own)
        first, place = first + m, place + n * m
    readings = np.concatenate(rows)
    readings = np.ascontiguousarray(readings[np.argsort(readings[:, 0], kind="stable")])
    stops = stops_ns / NS_PER_MS
    neurons = np.concatenate([trace.neurons for trace in traces])
    return Plan(stops, np.nextafter(stops, inf), readings, neurons, np.zeros(2, np.int64))


class PlasticState(NamedTuple):
    """Plastic synapses at some time: their records, shape ``(n,)``, and the signs of their weights."""

    plastic: Array
    slow: Array
    signs: IntArray

    @classmethod
    def room(cls, plastic: Array, slow: Array, rules: Array, rows: Array) -> PlasticState:
        """Return records that are still to be filled, of the synapses in these rows."""
        signs: IntArray = rules["sign"][plastic["rule"][rows]]
        return cls(np.empty(len(rows), plastic.dtype), np.empty(len(rows), slow.dtype), signs)

    @property
    def weights(self) -> FloatArray:
        """The weights."""
        weights: FloatArray = self.plastic["weight"] * self.signs
        return weights

    def variable(self, projection: Projection, name: str) -> FloatArray:
        """Return a state variable in its unit: of the equations, or else the eligibility."""
        if projection.equations is not None:
            return state_of(self.plastic, self.slow, projection, name)
        eligibilities: FloatArray = self.slow["pre_slow"] * self.signs
        return eligibilities


@jit
def run_reading(
    places: Array, stops: Array, ends: Array, readings: Array, neurons: Array, done: Array,
    last: int, out: Array,
) -> int:  # fmt: skip
    """Follow a plan up to its stop number ``last``; returns as :func:`nrp_brain_event.kernels.run`."""
    while done[0] < last:
        status = run(places, stops[done[0]], ends[done[0]])
        if status != DONE:
            return int(status)
        while done[1] < len(readings) and readings[done[1], 0] == done[0]:
            variable, first = readings[done[1], 1], readings[done[1], 2]
            n, place = readings[done[1], 3], readings[done[1], 4]
            read(places, neurons[first : first + n], variable, out[place : place + n])
            done[1] += 1
        done[0] += 1
    return DONE


def change_parameters(engine: EngineArrays, network: Network, change: ParameterChange) -> EngineArrays:
    """Change parameters of cells, and return the engine with their coefficients.

    Raises:
        NetworkError: a parameter is impossible.
    """
    first_id = network.offsets[change.label]
    rows = engine.row_of[first_id + change.index]
    changed = with_parameters(engine.cells[rows], network.populations[change.label], change.values, first_id)
    begin_anew(engine, rows)
    frozen = rows[engine.cells["synapse"][rows] == FROZEN]
    input_mv = engine.cells["x"][frozen] * engine.cells["resistance"][frozen, None]
    for name in CellParameters.dtype().names or ():
        engine.cells[name][rows] = changed[name]
    engine.cells["x"][frozen] = input_mv / engine.cells["resistance"][frozen, None]
    if change.values.keys() & TIME_CONSTANTS.keys() and len(engine.short_term):
        _follow_time_constants(engine)
    modes, kinds = modes_of(engine.cells)
    others = np.delete(np.arange(len(modes)), rows)
    for name in set(Modes.dtype().names or ()) - {"kind"}:
        modes[name][others] = engine.modes[name][others]
    return engine._replace(modes=modes, kinds=kinds)


def plastic_now(engine: EngineArrays, rows: Array) -> PlasticState:
    """Return the plastic synapses in these rows at the present time."""
    events, passed = engine.events, _passed(engine)
    synapses = ~events["target"][passed]
    order = np.argsort(synapses, kind="stable")
    found = PlasticState.room(engine.plastic, engine.slow, engine.rules, rows)
    synapses_at(
        float(engine.clock["now"][0]), engine.cells, engine.plastic, engine.slow, engine.rules, events,
        synapses[order], events["time"][passed][order], rows, found.plastic, found.slow,
    )  # fmt: skip
    return found


def require_slow(saved: Mapping[str, object], plastic: Array) -> None:
    """Check that the state of plastic synapses has the present form.

    Raises:
        SnapshotError: it was saved by version 0.2.0 or before, whose records are longer.
    """
    if len(plastic) and "slow" not in saved:
        raise SnapshotError(
            "the snapshot is from version 0.2.0 or before, whose plastic synapses have another form; run "
            "the network up to this time again"
        )


def change_weights(engine: EngineArrays, projection: Projection, rows: Array, weights: FloatArray) -> None:
    """Change the weights of synapses in these rows; spikes that have passed them keep the old ones."""
    if not projection.is_plastic:
        engine.weight[rows] = weights
        return
    bring_to_present(engine)
    engine.plastic["weight"][rows] = weights * _signs(engine, rows)


def change_plasticity(engine: EngineArrays, rows: Array, plastic: bool) -> None:
    """Stop or continue the learning of synapses in these rows; it is complete up to now."""
    bring_to_present(engine)
    freeze(engine.rules, engine.plastic["rule"][rows], not plastic)


def freeze(rules: Array, numbers: Array, frozen: bool) -> None:
    """Set in place whether the weights of synapses with these rules stay; each rule is of one projection."""
    rules["frozen"][np.unique(numbers)] = frozen


def bring_to_present(engine: EngineArrays) -> None:
    """Update all plastic synapses to the present time."""
    now = float(engine.clock["now"][0])
    bring_up_to(now, engine.cells, engine.plastic, engine.slow, engine.rules, engine.events, _passed(engine))


def _passed(engine: EngineArrays) -> IntArray:
    """Return the events that have passed their plastic synapses, in the order in which they did."""
    events, now = engine.events, float(engine.clock["now"][0])
    flying = np.flatnonzero(events["target"] < 0)
    heard = events["time"][flying] - engine.plastic["dendritic_delay"][~events["target"][flying]]
    passed: IntArray = flying[heard <= now][np.argsort(heard[heard <= now], kind="stable")]
    return passed


def _signs(engine: EngineArrays, rows: Array) -> IntArray:
    signs: IntArray = engine.rules["sign"][engine.plastic["rule"][rows]]
    return signs


def _follow_time_constants(engine: EngineArrays) -> None:
    """Set the decay of the targets' synapses for short-term plasticity."""
    synapses = np.flatnonzero(engine.dynamics >= 0)
    targets = engine.target[synapses]
    cells = engine.cells[targets >> 1]
    taus = cells["tau_syn"][np.arange(len(cells)), targets & 1]
    engine.short_term["tau_psc"][engine.dynamics[synapses]] = np.where(cells["synapse"] == JUMP, 0.0, taus)
