"""Convert the populations of a network to the arrays of its neurons.

The constants that a core derives from the parameters of its neurons when it starts.

All come from s16.15 parameters by the machine's truncating division and tabulated exponential.

The initial state of neurons.

The properties of a network that the synapses of every law are loaded with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import (
    FRACTION_LARGEST,
    LARGEST,
    ONE,
    ceiling,
    div,
    exact_exp,
    exp_accum,
    exp_fraction,
    from_accum,
    mul,
    to_accum,
    to_fraction,
)
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.neuron_kernels import FINE_BITS, LIFT_BITS, OPEN, gate_rates
from nrp_brain_spinnaker.models import CONDUCTANCE_SCALE, GSYN, ISYN, CellModel, Semantics, cell_models
from nrp_brain_spinnaker.options import SpinnakerOptions, hinted_substeps
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import nanoseconds
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.data import Network, Population


def synapse_constants(kind: int, step: int, tau: int) -> tuple[int, int, int]:
    """Return decay, init and gain of a synapse.

    Args:
        kind: the synapse.
        step: length of a (sub-)step, ms, s16.15.
        tau: time constant, ms, s16.15.
    """
    if kind == kinds.DELTA:
        return 0, 0, 0
    if kind == kinds.PEAKED_ALPHA:
        return _peaked_constants(step, tau)
    decay = exp_fraction(-div(step, tau))
    if kind == kinds.ALPHA:  # the integer part of the slope is lost, as on the machine
        return decay, 0, div(step, mul(tau, tau)) & (ONE - 1)
    init = ((div(tau, step) * (FRACTION_LARGEST - decay)) >> 15) & FRACTION_LARGEST
    return decay, init, 0


def _peaked_constants(step: int, tau: int) -> tuple[int, int, int]:
    """Return the constants of an alpha function with peak 1, averaged over each step."""
    with localcontext(prec=40):
        x, e = Decimal(step) / Decimal(tau), exact_exp(Decimal(1))
        decay = exact_exp(-x)
        first_mean = e / x * (1 - decay * (1 + x))
        return to_fraction(decay), to_fraction(first_mean), to_fraction(e * decay * (1 - decay))


def membrane_constants(kind: int, step: int, raw: Mapping[str, int]) -> dict[int, int]:
    """Return the constants of a membrane by row, from s16.15 parameters and the (sub-)step."""
    if kind == kinds.IZHIKEVICH:
        parameters = zip((kinds.IZK_A, kinds.IZK_B, kinds.IZK_C, kinds.IZK_D), "abcd", strict=True)
        return {row: raw[name] for row, name in parameters} | {kinds.H_RESET: step}
    if kind == kinds.HODGKIN_HUXLEY:
        return _hodgkin_huxley(step, raw)
    if kind == kinds.ADAPTIVE_EXPONENTIAL:
        return _leaky(step, raw, raw["v_spike"]) | _adaptive(step, raw)
    return _leaky(step, raw, raw["v_thresh"])


def _leaky(step: int, raw: Mapping[str, int], threshold: int) -> dict[int, int]:
    return {
        kinds.R_MEMBRANE: div(raw["tau_m"], raw["cm"]),
        kinds.EXP_TC: exp_accum(-div(step, raw["tau_m"])),
        kinds.V_REST: raw["v_rest"],
        kinds.V_RESET: raw["v_reset"],
        kinds.V_THRESH: threshold,
        kinds.T_REFRACTORY: ceiling(div(raw["tau_refrac"], step)),
    }


def _adaptive(step: int, raw: Mapping[str, int]) -> dict[int, int]:
    """Return further constants of adaptive exponential cells; without a slope they fire at ``v_thresh``."""
    slope = raw["delta_T"]
    return {
        kinds.V_THRESH: raw["v_spike"] if slope else raw["v_thresh"],
        kinds.V_SOFT: raw["v_thresh"],
        kinds.SLOPE: slope,
        kinds.INVERSE_SLOPE: div(ONE, slope) if slope else 0,
        kinds.MEMBRANE_DECAY: _exact_decay(step, raw["tau_m"]),
        kinds.ADAPTATION: raw["a"],
        kinds.ADAPTATION_DECAY: _exact_decay(step, raw["tau_w"]),
        kinds.ADAPTATION_JUMP: raw["b"],
    }


def _exact_decay(step: int, tau: int) -> int:
    return to_fraction(exact_exp(-Decimal(step) / Decimal(tau)))


def _hodgkin_huxley(step: int, raw: Mapping[str, int]) -> dict[int, int]:
    names = {
        kinds.G_SODIUM: "gbar_Na", kinds.G_POTASSIUM: "gbar_K", kinds.G_LEAK: "g_leak",
        kinds.E_SODIUM: "e_rev_Na", kinds.E_POTASSIUM: "e_rev_K", kinds.E_LEAK: "e_rev_leak",
        kinds.V_OFFSET: "v_offset",
    }  # fmt: skip
    lift = (step << LIFT_BITS) // raw["cm"]
    return {row: raw[name] for row, name in names.items()} | {kinds.LIFT: lift, kinds.STEP: step}


def resting_gates(v_above_offset: int) -> tuple[int, int, int]:
    """Return the steady-state gates m, h and n at a voltage, s16.15, in units of 2**-30."""
    rates = gate_rates(v_above_offset)
    m, h, n = (OPEN * rates[k] // (rates[k] + rates[k + 1]) for k in (0, 2, 4))
    return m, h, n


GATES = {"m": kinds.GATE_M, "h": kinds.GATE_H, "n": kinds.GATE_N}
ROWS = {"v": kinds.V, "u": kinds.U, "w": kinds.W, **GATES}
"""The row of each variable of a membrane."""


def load_state(cells: Cells, own: slice, population: Population, model: CellModel, step: int) -> None:
    """Set the initial values of a population; by default gates are at their steady state for the voltage.

    Raises:
        NetworkError: a value does not fit the machine's numbers or the cells have no such variable.
    """
    if model.neuron == kinds.IZHIKEVICH:
        cells.state[kinds.H, own] = step
    for name, values in population.initial_values.items():
        if name not in model.state_variables:
            hint = did_you_mean(name, model.state_variables)
            raise NetworkError(
                f"population '{population.label}' ({population.cell_type}) has no '{name}'{hint}"
            )
        _set(cells, own, model, name, values, population.label)
    if model.neuron == kinds.HODGKIN_HUXLEY:
        cells.state[kinds.V_FINE, own] = cells.state[kinds.V, own] << FINE_BITS
        _rest_gates(cells, own, [name for name in GATES if name not in population.initial_values])


def _set(cells: Cells, own: slice, model: CellModel, name: str, values: FloatArray, label: str) -> None:
    if name in GATES:
        cells.state[GATES[name], own] = np.rint(values * OPEN)
        return
    scale = state_scale(model, name)
    try:
        raw = to_accum(values * scale, f"initial value '{name}'")
    except ValueError as error:
        raise NetworkError(f"population '{label}': {error}") from None
    if name in (*GSYN, *ISYN):
        cells.synapse_state[int(name.endswith("inh")), kinds.VALUE, own] = raw
    else:
        cells.state[ROWS[name], own] = raw


def state_scale(model: CellModel, name: str) -> int:
    """Return the factor with which a variable is stored."""
    if name == "isyn_inh":  # PyNN's inhibitory currents are negative; the machine subtracts
        return -model.weight_scale
    if name in (*GSYN, *ISYN):
        return model.weight_scale
    return CONDUCTANCE_SCALE if name == "w" else 1


def _rest_gates(cells: Cells, own: slice, names: list[str]) -> None:
    above = cells.state[kinds.V, own] - cells.constants[kinds.V_OFFSET, own]
    for voltage in np.unique(above).tolist():
        gates = dict(zip(GATES, resting_gates(voltage), strict=True))
        neurons = np.flatnonzero(above == voltage) + own.start
        for name in names:
            cells.state[GATES[name], neurons] = gates[name]


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
        return -(nanoseconds(times_ms) // 1000 // -self.step_us)

    def substeps_of(self, model: CellModel, population: Population) -> int:
        """Return the number of updates of the cells of a population in a tick."""
        return max(self.substeps, model.substeps(self.step_us), hinted_substeps(population))


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
    substeps = [grid.substeps_of(model, own) for model, own in zip(models, populations, strict=True)]
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


@dataclass(frozen=True, slots=True)
class Layout:
    """The properties of a network on the machine.

    Args:
        network: the network.
        options: the options of the user.
        n: number of simulated neurons.
        tau_syn: time constant of the synapse behind each line, s16.15, shape ``(2 n,)``.
        grid: the time step.
    """

    network: Network
    options: SpinnakerOptions
    n: int
    tau_syn: IntArray
    grid: Grid

    @property
    def n_sources(self) -> int:
        """Number of global ids."""
        return self.network.size
