"""Convert the populations of a network to the arrays of its neurons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.constants import membrane_constants, synapse_constants
from nrp_brain_spinnaker.host.conversion import from_accum, to_accum
from nrp_brain_spinnaker.host.initial_state import load_state
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import LARGEST, ONE, div
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.models import CONDUCTANCE_SCALE, CellModel, Semantics, cell_models
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.data import Population
from nrp_core.errors import NetworkError

_SHARED = {"tau_syn_E": 5.0, "tau_syn_I": 5.0, "e_rev_E": 0.0, "e_rev_I": -70.0, "i_offset": 0.0}
"""Parameters of all cells on the machine, with default values for cells without them in PyNN."""
_NEVER_REACHED = ("v_thresh", "v_spike")
_NOT_ZERO = ("tau_m", "cm", "tau_w")


@dataclass(frozen=True, slots=True)
class Grid:
    """The time step of the machine.

    Args:
        step_us: length of a tick, us.
        substeps: updates of a neuron in a tick.
    """

    step_us: int
    substeps: int = 1

    @property
    def step(self) -> int:
        """Length of a tick, ms, s16.15."""
        return int(to_accum(self.step_us / 1000))

    def first_tick_at(self, times_ms: FloatArray) -> IntArray:
        """Return the first tick at or after each time; times are rounded to whole microseconds."""
        return -(np.floor(times_ms * 1000).astype(np.int64) // -self.step_us)

    def substeps_of(self, model: CellModel) -> int:
        """Return the number of updates of cells of a model in a tick."""
        return max(self.substeps, model.substeps(self.step_us))


def load_cells(populations: Sequence[Population], ids: IntArray, grid: Grid, semantics: Semantics) -> Cells:
    """Build the neurons of populations, at their initial values, with left shifts of 0.

    Args:
        populations: without source populations.
        ids: global ids of all neurons.
        grid: the time step.
        semantics: the meaning of the cell types, PyNN's or the released software's.

    Raises:
        NetworkError: a parameter does not fit the machine's numbers.
    """
    models = [cell_models(semantics)[population.cell_type] for population in populations]
    substeps = [grid.substeps_of(model) for model in models]
    most_spikes = sum(p.size * n for p, n in zip(populations, substeps, strict=True))
    cells = _blank(len(populations), ids, most_spikes)
    first = 0
    for index, (population, model) in enumerate(zip(populations, models, strict=True)):
        own = slice(first, first + population.size)
        row = (first, own.stop, model.synapse, model.input, model.neuron, substeps[index], 0, 0)
        cells.populations[index] = row
        _load_constants(cells, own, population, model, grid.step // substeps[index])
        load_state(cells, own, population, model, grid.step)
        first = own.stop
    return cells


def _blank(n_populations: int, ids: IntArray, most_spikes: int) -> Cells:
    n = ids.size
    return Cells(
        populations=np.zeros((n_populations, kinds.POPULATION_COLUMNS), np.int64),
        constants=np.zeros((kinds.CONSTANT_ROWS, n), np.int64),
        state=np.zeros((kinds.STATE_ROWS, n), np.int64),
        synapse_constants=np.zeros((2, kinds.SYNAPSE_ROWS, n), np.int64),
        synapse_state=np.zeros((2, kinds.SYNAPSE_ROWS, n), np.int64),
        current=np.zeros(n, np.int64),
        ids=ids,
        arrived=np.zeros((2, n), np.int64),
        value=np.zeros((2, n), np.int64),
        drive=np.zeros(n, np.int64),
        fired=np.zeros(most_spikes, np.int64),
        n_fired=np.zeros(1, np.int64),
    )


def tau_syn_of_lines(populations: Sequence[Population], semantics: Semantics) -> IntArray:
    """Return the synaptic time constant of each line, s16.15; 0 for delta synapses."""
    parts = [np.empty(0, np.int64)]
    for name in ("tau_syn_E", "tau_syn_I"):
        for population in populations:
            model = cell_models(semantics)[population.cell_type]
            lasts = model.synapse != kinds.DELTA
            parts.append(_raw(population, name, model) if lasts else np.zeros(population.size, np.int64))
    return np.concatenate(parts)


def _load_constants(cells: Cells, own: slice, population: Population, model: CellModel, step: int) -> None:
    names = (*model.parameters, *_SHARED)
    values = np.stack([_raw(population, name, model) for name in names])
    distinct, which = np.unique(values, axis=1, return_inverse=True)
    for index, column in enumerate(distinct.T.tolist()):
        raw = dict(zip(names, column, strict=True))
        _check_times(population.label, model, raw, step)
        neurons = np.flatnonzero(which.ravel() == index) + own.start
        for row, value in _neuron_constants(model, step, raw).items():
            cells.constants[row, neurons] = value
        for receptor, suffix in enumerate("EI"):
            constants = synapse_constants(model.synapse, step, raw[f"tau_syn_{suffix}"])
            cells.synapse_constants[receptor][:, neurons] = np.reshape(constants, (-1, 1))


def _neuron_constants(model: CellModel, step: int, raw: Mapping[str, int]) -> dict[int, int]:
    shared = {kinds.I_OFFSET: "i_offset", kinds.E_REV_E: "e_rev_E", kinds.E_REV_I: "e_rev_I"}
    constants = {row: raw[name] for row, name in shared.items()}
    return constants | {kinds.IMPULSE_GAIN: div(ONE, step)} | membrane_constants(model.neuron, step, raw)


def _raw(population: Population, name: str, model: CellModel) -> IntArray:
    """Return a parameter of all neurons, s16.15."""
    if name not in population.parameters and name not in _SHARED:
        raise NetworkError(f"population '{population.label}' ({population.cell_type}) has no '{name}'")
    given = population.parameters.get(name)
    values = np.full(population.size, _SHARED[name]) if given is None else given
    if name in _NEVER_REACHED:
        values = np.where(np.isposinf(values), from_accum(LARGEST), values)
    try:
        raw = to_accum(values * _unit(name, model), f"parameter '{name}'")
    except ValueError as error:
        raise NetworkError(f"population '{population.label}': {error}") from None
    if name in _NOT_ZERO and (raw <= 0).any():
        raise NetworkError(
            f"population '{population.label}': {name} of {values.min():g} is 0 in the machine's numbers; "
            f"it must be at least {1 / ONE:g}"
        )
    return raw


def _unit(name: str, model: CellModel) -> float:
    """Return the factor of a parameter on the machine."""
    if name == "i_offset":
        return model.current_scale
    if model.neuron == kinds.ADAPTIVE_EXPONENTIAL and name in "ab":
        return CONDUCTANCE_SCALE * (1e-3 if name == "a" else 1.0)  # a is in nS in PyNN
    return 1.0


def _check_times(label: str, model: CellModel, raw: Mapping[str, int], step: int) -> None:
    """Refuse time constants for which the machine's division gives 0 or a wrong result."""
    names = ["tau_m"] if "tau_m" in raw else []
    names += [] if model.synapse == kinds.DELTA else ["tau_syn_E", "tau_syn_I"]
    least = 182 if model.synapse == kinds.ALPHA else 1  # whose square is not 0
    for name in names:
        if raw[name] < least or div(step, raw[name]) == 0:
            raise NetworkError(
                f"population '{label}': {name} is {from_accum(raw[name]):g} ms; with an update every "
                f"{from_accum(step):g} ms the machine needs {least / ONE:.2g} .. {min(step, ONE - 1):g} ms"
            )
