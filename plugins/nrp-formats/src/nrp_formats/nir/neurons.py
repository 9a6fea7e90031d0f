"""Nodes of neurons as PyNN's cells, at the step at which the network was trained.

A unit of voltage becomes 1 mV. In a step of length dt, a spike is a pulse of height 1: the membrane of a
LIF node rises by ``weight r dt / tau``, that of an IF node by ``weight r dt``, and the current of a CubaLIF
node by ``weight w_in dt / tau_syn``. Cells fire above the threshold, not at it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.network.filters import driven
from nrp_formats.nir.graded import Current, without_leak
from nrp_formats.nir.linear import Shape, parameters_of

Method = Literal["exact", "euler", "held"]
_NO_LEAK_MS: Final = 1e15
"""A time constant beside which every step is so short that ``exp(-step/tau)`` is 1."""
_NO_MEMORY: Final = 1e-30
"""What remains of a voltage after a step where nothing shall remain."""

_RELAYED: Final = 3e-9
"""The same for relays, whose threshold is far from any input: a time constant that looks like one."""

_driven = np.vectorize(driven)
_BEHIND_A_CURRENT: Final = {"tau": "tau_mem", "threshold": "v_threshold"}
"""Names of parameters of the other nodes as those of CubaLIF."""


@dataclass(frozen=True)
class Cells:
    """The cells of a node.

    Args:
        cell_type: PyNN's name.
        parameters: PyNN's names and units, one value a cell.
        per_weight: the weight of a synapse for a weight of 1 in the file, for each cell.
        late: 1 if an input acts on the voltage only in the step after its arrival.
        initial: state variables at time 0, for a cell whose clock is ``lag`` steps late.
        kick: mV that an input of 1 adds to the voltage as it arrives, for each cell; None for cells whose
            input acts through their current alone.
    """

    cell_type: str
    parameters: dict[str, FloatArray]
    per_weight: FloatArray
    late: int = 0
    initial: dict[str, FloatArray] = field(default_factory=dict)
    kick: FloatArray | None = None


@dataclass(frozen=True)
class Step:
    """The step of the network.

    Args:
        dt_s: its length where it was trained, in the time of the file.
        h_ms: its length here.
        method: ``euler`` if states decay by ``1 - dt/tau`` in a step, and currents act in the step in which
            they change; ``exact`` for the equations themselves; ``held`` for these where each input to a
            voltage lasts for a step.
        refractory: steps after a spike in which a voltage stays at its reset value.
    """

    dt_s: float
    h_ms: float
    method: Method
    refractory: int = 0

    @property
    def late(self) -> int:
        """The steps that an input takes through a current to a voltage, beyond those of the file."""
        return int(self.method != "exact")

    def rise(self, tau_s: FloatArray, decay: FloatArray) -> FloatArray:
        """Return the share of an input that a state takes on in a step."""
        return np.asarray(1.0 - decay if self.method == "held" else self.dt_s / tau_s)

    def decay(self, tau_s: FloatArray) -> FloatArray:
        """Return the share of a state that remains after a step.

        Raises:
            ValueError: a time constant is too short.
        """
        if not (tau_s > 0).all() or (self.method == "euler" and (tau_s < self.dt_s * (1 - 1e-6)).any()):
            limit = f"at least the step, {self.dt_s:g} s" if self.method == "euler" else "more than 0 s"
            raise ValueError(f"a time constant is {tau_s.min():g} s; it must be {limit}")
        share = 1.0 - self.dt_s / tau_s if self.method == "euler" else np.exp(-self.dt_s / tau_s)
        return np.maximum(share, _NO_MEMORY)

    def tau_ms(self, decay: FloatArray) -> FloatArray:
        """Return the time constant of a state, from the fraction that remains after a step."""
        return np.asarray(-self.h_ms / np.log(decay))

    def tau_s(self, tau_ms: FloatArray) -> FloatArray:
        """Return the time constant in the file of a state that has this one here."""
        if self.method == "euler":
            return np.asarray(self.dt_s / -np.expm1(-self.h_ms / tau_ms))
        return np.asarray(tau_ms * (self.dt_s / self.h_ms))


def cells_of(
    node: Any, shape: Shape, bias: FloatArray, step: Step, lag: int, current: Current | None = None,
    *, kicked: bool = False,
) -> Cells:  # fmt: skip
    """Return the cells of a node.

    Args:
        node: the node.
        shape: its shape.
        bias: the constant input of each cell.
        step: the step.
        lag: delay of its spikes relative to the file, steps.
        current: the current through which all other input passes.
        kicked: whether an input through a current acts on the voltage as it arrives, see :attr:`Cells.kick`.

    Raises:
        ValueError: the node has impossible parameters.
    """
    kind = type(node).__name__
    given = {name: np.broadcast_to(value, shape).ravel() for name, value in parameters_of(node).items()}
    if current is not None:
        given = given if "tau" in given or "r" not in given else without_leak(given, step.dt_s)
        own = {"v_leak": np.zeros(len(bias))} | {_BEHIND_A_CURRENT.get(k, k): v for k, v in given.items()}
        own |= {"tau_syn": current.tau_s, "w_in": np.ones(len(bias))}
        cells = _current_based(own, current.bias, step, lag, bias, kicked)
        return replace(cells, per_weight=step.rise(current.tau_s, step.decay(current.tau_s)))
    if kind in {"CubaLIF", "CubaLI"}:
        return _current_based(given, bias, step, lag, np.zeros(len(bias)), kicked)
    return _delta(given, bias, step, lag)


def driven_by(h_ms: float, tau_ms: FloatArray, tau_syn_ms: FloatArray) -> FloatArray:
    """Return how a current of 1 nA that decays with ``tau_syn`` moves the voltage of 1 nF in a step, mV."""
    decay, faded = np.exp(-h_ms / tau_ms), np.exp(-h_ms / tau_syn_ms)
    return np.asarray(_driven(h_ms, decay, faded, 1.0 / tau_syn_ms - 1.0 / tau_ms, 1.0, 0.0))


def relays(n: int, step: Step) -> Cells:
    """Return cells that fire when an input of 1 mV, or more than half of it, arrives."""
    parameters = _membrane(
        np.full(n, _RELAYED), replace(step, refractory=0), np.full(n, 0.5), np.zeros(n), np.zeros(n)
    )
    return Cells("IF_curr_delta", parameters, np.ones(n))


def _delta(given: dict[str, FloatArray], bias: FloatArray, step: Step, lag: int) -> Cells:
    """Return cells whose voltage jumps by the weights: LIF, IF, LI, I, Threshold."""
    n = len(bias)
    rest, reset = given.get("v_leak", np.zeros(n)), given.get("v_reset", np.zeros(n))
    threshold = given.get("v_threshold", given.get("threshold", np.full(n, np.inf)))
    if "tau" in given:
        decay = step.decay(given["tau"])
        rise = given["r"] * step.rise(given["tau"], decay)
        tau = step.tau_ms(decay)
    elif "r" in given:
        decay, rise, tau = np.ones(n), given["r"] * step.dt_s, np.full(n, _NO_LEAK_MS)
    else:
        decay, rise = np.full(n, _NO_MEMORY), np.ones(n)
        tau = step.tau_ms(decay)
    parameters = _membrane(decay, step, threshold, rest, reset)
    gain = np.where(tau == _NO_LEAK_MS, step.h_ms, (1.0 - decay) * tau)  # mV in a step by 1 nA into 1 nF
    push = bias * (rise if step.method == "euler" or "tau" not in given else (1.0 - decay) * given["r"])
    parameters["tau_m"], parameters["i_offset"] = tau, push / gain
    start = _before(lag, decay, push)
    return Cells("IF_curr_delta", parameters, rise, initial={"v": rest + start})


def _current_based(
    given: dict[str, FloatArray], bias: FloatArray, step: Step, lag: int, direct: FloatArray, kicked: bool
) -> Cells:
    """Return cells with a current that decays: CubaLIF, CubaLI, and others behind an integrator.

    Args:
        given: the parameters of a CubaLIF; without ``tau_mem`` the voltage is the current.
        bias: the constant input of the current of each cell.
        step: the step.
        lag: delay of its spikes relative to the file, steps.
        direct: the constant input of each voltage.
        kicked: see :func:`cells_of`.
    """
    n = len(bias)
    follows = "tau_mem" not in given
    decay = np.full(n, _NO_MEMORY) if follows else step.decay(given["tau_mem"])
    faded = step.decay(given["tau_syn"])
    tau, tau_syn = step.tau_ms(decay), step.tau_ms(faded)
    threshold = given.get("v_threshold", np.full(n, np.inf))
    parameters = _membrane(decay, step, threshold, given["v_leak"], given.get("v_reset", np.zeros(n)))
    area = driven_by(step.h_ms, tau, tau_syn)
    rise = np.ones(n) if follows else given["r"] * step.rise(given["tau_mem"], decay)
    at_once = late_of(step, follows=follows)
    late = 0 if kicked else at_once
    cm = area / (rise * faded if kicked else rise) if at_once else tau / given["r"]
    settled = given["w_in"] * bias
    gain = (1.0 - decay) * tau / cm
    effect = area / cm
    # the current of the bias rises with tau_syn: all of it at once, less a current that decays
    offset = (settled + direct) * (rise if at_once else (1.0 - decay) * given["r"]) / gain
    parameters |= {"tau_m": tau, "cm": cm, "tau_syn_E": tau_syn, "tau_syn_I": tau_syn, "i_offset": offset}
    current = -settled * faded ** float(late - lag)
    drives = [offset * gain + effect * current * faded**k for k in range(lag)]
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # the state may be infinite
        start = -sum((drive * decay ** (lag - 1 - k) for k, drive in enumerate(drives)), np.zeros(n))
        start = start / decay**lag
    initial = {"v": given["v_leak"] + start, "isyn_exc": current}
    per_weight = given["w_in"] * step.dt_s / given["tau_syn"]
    return Cells("IF_curr_exp", parameters, per_weight, late, initial, rise if kicked else None)


def late_of(step: Step, *, follows: bool) -> int:
    """Return the steps that an input takes through a current to a voltage, beyond those of the file.

    Args:
        step: the step.
        follows: whether the voltage is the current, without memory.
    """
    return max(step.late, int(follows))


def _membrane(
    decay: FloatArray, step: Step, threshold: FloatArray, rest: FloatArray, reset: FloatArray
) -> dict[str, FloatArray]:
    endless = np.flatnonzero(reset >= threshold)
    if endless.size:
        cell = endless[0]
        raise ValueError(
            f"v_reset of cell {cell} is {reset[cell]:g}; it must be less than its v_threshold, "
            f"{threshold[cell]:g}"
        )
    refractory_ms = np.full(len(decay), step.refractory * step.h_ms)
    return {
        "tau_m": step.tau_ms(np.minimum(decay, 1.0 - 1e-16)), "cm": np.ones(len(decay)), "v_rest": rest,
        "v_reset": reset, "v_thresh": np.nextafter(threshold, np.inf), "tau_refrac": refractory_ms,
        "i_offset": np.zeros(len(decay)),
    }  # fmt: skip


def _before(lag: int, decay: FloatArray, drive: FloatArray) -> FloatArray:
    """Return the state that a constant drive takes to 0 in ``lag`` steps; it may be infinite."""
    state = np.zeros(len(decay))
    with np.errstate(over="ignore"):
        for _ in range(lag):
            state = (state - drive) / decay
    return state
