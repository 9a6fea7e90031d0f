"""Changes of the engine between two runs: parameters of cells, weights of synapses."""

from __future__ import annotations

import numpy as np

from nrp_brain_event.cell_types import TIME_CONSTANTS
from nrp_brain_event.cells import with_parameters
from nrp_brain_event.kernels import begin_anew
from nrp_brain_event.modes import modes_of
from nrp_brain_event.plasticity import bring_up_to
from nrp_brain_event.records import FROZEN, JUMP, CellParameters, EngineArrays, Modes
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.changes import ParameterChange
from nrp_core.brain.network.data import Network, Projection


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


def weights_now(engine: EngineArrays, projection: Projection, rows: IntArray) -> FloatArray:
    """Return the weights of a projection whose synapses are in these rows."""
    if not projection.is_plastic:
        return engine.weight[rows]
    seen = _up_to_date(engine._replace(plastic=engine.plastic.copy(), events=engine.events.copy()))
    return seen.plastic["weight"][rows] * _signs(seen, rows)


def change_weights(engine: EngineArrays, projection: Projection, rows: IntArray, weights: FloatArray) -> None:
    """Change the weights of synapses in these rows; spikes that have passed them keep the old ones."""
    if not projection.is_plastic:
        engine.weight[rows] = weights
        return
    _up_to_date(engine)
    engine.plastic["weight"][rows] = weights * _signs(engine, rows)


def _up_to_date(engine: EngineArrays) -> EngineArrays:
    """Update all plastic synapses to the present time."""
    events, plastic, now = engine.events, engine.plastic, float(engine.clock["now"][0])
    flying = np.flatnonzero(events["target"] < 0)
    heard = events["time"][flying] - plastic["dendritic_delay"][~events["target"][flying]]
    passed = flying[heard <= now][np.argsort(heard[heard <= now], kind="stable")]
    bring_up_to(now, engine.cells, plastic, engine.rules, events, passed)
    return engine


def _signs(engine: EngineArrays, rows: IntArray) -> IntArray:
    signs: IntArray = engine.rules["sign"][engine.plastic["rule"][rows]]
    return signs


def _follow_time_constants(engine: EngineArrays) -> None:
    """Set the decay of the targets' synapses for short-term plasticity."""
    synapses = np.flatnonzero(engine.dynamics >= 0)
    targets = engine.target[synapses]
    cells = engine.cells[targets >> 1]
    taus = cells["tau_syn"][np.arange(len(cells)), targets & 1]
    engine.short_term["tau_psc"][engine.dynamics[synapses]] = np.where(cells["synapse"] == JUMP, 0.0, taus)
