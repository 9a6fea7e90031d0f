"""A fine reference: every standard cell by its published equations, integrated in steps of 10 us.

Runge-Kutta of fourth order in plain Python, independent of every backend. Names and units are
PyNN's (ms, mV, nF, nA, uS; ``a`` in nS).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, e, exp, inf

from nrp_conformance.brain.kit import Sample

STEP_MS = 0.01
State = list[float]
Slopes = Callable[[State, float], State]


@dataclass(frozen=True, slots=True)
class Arrival:
    """A spike that reaches a synapse."""

    time_ms: float
    weight: float
    receptor: str = "excitatory"


@dataclass(frozen=True, slots=True)
class ReferenceTrace:
    """The response of a cell.

    Args:
        voltages: its membrane potential every :data:`STEP_MS`.
        spikes: its spike times, ms.
        recoveries: its second variable (``w``, ``u``) at the times of the voltages, if it has one.
    """

    voltages: tuple[float, ...]
    spikes: tuple[float, ...]
    recoveries: tuple[float, ...]

    def voltage(self, t_ms: float) -> float:
        """Return the membrane potential at the step nearest to a time, mV."""
        return self.voltages[max(0, min(len(self.voltages) - 1, round(t_ms / STEP_MS)))]

    def change(self, t_ms: float, within_ms: float) -> float:
        """Return the change of the membrane potential within ``within_ms`` before and after a time, mV."""
        reach, middle = ceil(within_ms / STEP_MS - 1e-9), round(t_ms / STEP_MS)
        near = self.voltages[max(0, middle - reach) : middle + reach + 1]
        return max(near) - min(near)


def simulate(
    sample: Sample, arrivals: Sequence[Arrival] = (), *, until_ms: float, current_na: float = 0.0,
    stop_at: float = inf, **parameters: float,
) -> ReferenceTrace:  # fmt: skip
    """Integrate a cell from rest.

    Args:
        sample: the cell.
        arrivals: the spikes that reach it; times are multiples of :data:`STEP_MS`.
        until_ms: the duration, ms.
        current_na: a constant current in addition to ``i_offset``, nA.
        stop_at: stop after this number of spikes.
        parameters: changes of the sample's parameters.
    """
    changes = tuple(sorted(parameters.items()))
    return _simulate(sample, tuple(arrivals), until_ms, current_na, stop_at, changes)


@lru_cache(maxsize=64)  # a suite asks for some of them several times, and another backend for the same ones
def _simulate(
    sample: Sample, arrivals: tuple[Arrival, ...], until_ms: float, current_na: float, stop_at: float,
    changes: tuple[tuple[str, float], ...],
) -> ReferenceTrace:  # fmt: skip
    cell = _cell(sample, {**sample.all_parameters, **dict(changes)}, current_na)
    due: dict[int, list[Arrival]] = {}
    for arrival in arrivals:
        due.setdefault(round(arrival.time_ms / STEP_MS), []).append(arrival)
    voltages: list[float] = []
    spikes: list[float] = []
    recoveries: list[float] = []
    free_at = -inf
    for step in range(round(until_ms / STEP_MS) + 1):
        t = step * STEP_MS
        for arrival in due.get(step, ()):
            cell.receive(arrival, refractory=t < free_at - 1e-9)
        voltages.append(cell.y[0])
        recoveries.extend(cell.y[1 : min(2, cell.n_own)])
        crossed = cell.advance(max(0.0, free_at - t))
        if crossed is not None:
            spikes.append(t + crossed)
            if len(spikes) >= stop_at:
                break
            free_at = t + crossed + cell.refractory_ms
    return ReferenceTrace(tuple(voltages), tuple(spikes), tuple(recoveries))


def first_spike_ms(sample: Sample, arrivals: Sequence[Arrival], *, current_na: float = 0.0) -> float:
    """Return the time of the first spike of a cell that starts at rest."""
    until = max((arrival.time_ms for arrival in arrivals), default=0.0) + 50.0
    return simulate(sample, arrivals, until_ms=until, current_na=current_na, stop_at=1).spikes[0]


class _Cell:
    """A cell: ``y`` holds the membrane potential, its own variables, then two per synaptic time course."""

    def __init__(self, sample: Sample, p: Mapping[str, float], own: State, membrane: Slopes) -> None:
        self.p = p
        self.alpha = "_alpha" in sample.cell_type
        self.jumps = "tau_syn_E" not in p
        self.n_own = len(own)
        self.y = [*own, *([] if self.jumps else [0.0] * 4)]
        self.membrane = membrane
        self.threshold = p.get("v_thresh", inf)
        self.refractory_ms = p.get("tau_refrac", 0.0)
        self.conductances = "_cond_" in sample.cell_type

    def receive(self, arrival: Arrival, *, refractory: bool) -> None:
        """Apply a spike; it cannot change a membrane potential that is clamped."""
        inhibitory = arrival.receptor == "inhibitory"
        if self.jumps:
            self.y[0] += 0.0 if refractory else arrival.weight
        elif self.alpha:
            tau = self.p["tau_syn_I" if inhibitory else "tau_syn_E"]
            self.y[self.n_own + 2 * inhibitory + 1] += arrival.weight * e / tau
        else:
            self.y[self.n_own + 2 * inhibitory] += arrival.weight

    def advance(self, held_ms: float) -> float | None:
        """Take one step, with the membrane clamped in its first part; return the spike time within it."""
        if self.jumps and self.y[0] >= self.threshold:
            self._fire_and_go_on(STEP_MS)
            return 0.0
        start = min(held_ms, STEP_MS)
        if start > 0.0:
            self._step(start, held=True)
        before = self.y
        self._step(STEP_MS - start, held=False)
        if not before[0] < self.threshold <= self.y[0]:
            return None
        share = (self.threshold - before[0]) / (self.y[0] - before[0])
        self.y = [a + share * (b - a) for a, b in zip(before, self.y, strict=True)]
        rest = (1 - share) * (STEP_MS - start)
        self._fire_and_go_on(rest)
        return STEP_MS - rest

    def _fire_and_go_on(self, rest_ms: float) -> None:
        self.reset()
        self._step(rest_ms, held=self.refractory_ms > 0.0)

    def reset(self) -> None:
        """Apply the effect of a spike on the cell itself."""
        self.y[0] = self.p["v_reset"]

    def _step(self, h: float, *, held: bool) -> None:
        def moved(slope: State, share: float) -> State:
            return [a + share * h * b for a, b in zip(self.y, slope, strict=True)]

        k1 = self._slopes(self.y, held)
        k2 = self._slopes(moved(k1, 0.5), held)
        k3 = self._slopes(moved(k2, 0.5), held)
        k4 = self._slopes(moved(k3, 1.0), held)
        stages = zip(self.y, k1, k2, k3, k4, strict=True)
        self.y = [y + h / 6 * (a + 2 * b + 2 * c + d) for y, a, b, c, d in stages]

    def _slopes(self, y: State, held: bool) -> State:
        own = self.membrane(y, self._synaptic_current(y))
        if held:
            own[0] = 0.0
        if self.jumps:
            return own
        exc, exc_rise, inh, inh_rise = y[self.n_own :]
        tau_e, tau_i = self.p["tau_syn_E"], self.p["tau_syn_I"]
        return [
            *own, exc_rise - exc / tau_e, -exc_rise / tau_e, inh_rise - inh / tau_i, -inh_rise / tau_i
        ]  # fmt: skip

    def _synaptic_current(self, y: State) -> float:
        if self.jumps:
            return 0.0
        exc, inh = y[self.n_own], y[self.n_own + 2]
        if not self.conductances:
            return exc + inh
        return exc * (self.p["e_rev_E"] - y[0]) + inh * (self.p["e_rev_I"] - y[0])


class _Frozen(_Cell):
    """Shiu et al. (2024), Nature 634:210: input in mV, nothing moves or arrives in the refractory period."""

    def receive(self, arrival: Arrival, *, refractory: bool) -> None:
        if not refractory:
            super().receive(arrival, refractory=False)

    def reset(self) -> None:
        super().reset()
        self.y[1:] = [0.0] * 4

    def _synaptic_current(self, y: State) -> float:
        return super()._synaptic_current(y) * self.p["cm"] / self.p["tau_m"]


class _AdaptiveExponential(_Cell):
    """Brette & Gerstner (2005), J Neurophysiol 94:3637."""

    def __init__(self, sample: Sample, p: Mapping[str, float], own: State, membrane: Slopes) -> None:
        super().__init__(sample, p, own, membrane)
        self.threshold = p["v_spike"]

    def reset(self) -> None:
        super().reset()
        self.y[1] += self.p["b"]


class _Izhikevich(_Cell):
    """Izhikevich (2003), IEEE Trans Neural Netw 14:1569."""

    def __init__(self, sample: Sample, p: Mapping[str, float], own: State, membrane: Slopes) -> None:
        super().__init__(sample, p, own, membrane)
        self.threshold = 30.0

    def reset(self) -> None:
        self.y[0] = self.p["c"]
        self.y[1] += self.p["d"]


class _HodgkinHuxley(_Cell):
    """Traub & Miles (1991); a spike is an upward crossing of -20 mV, which resets nothing."""

    def __init__(self, sample: Sample, p: Mapping[str, float], own: State, membrane: Slopes) -> None:
        super().__init__(sample, p, own, membrane)
        self.threshold = -20.0

    def reset(self) -> None:
        pass


def _cell(sample: Sample, p: Mapping[str, float], current_na: float) -> _Cell:
    current = p["i_offset"] + current_na
    initial = sample.initial_values
    v = initial["v"]
    if "u" in initial:
        per_na = 1000.0 if sample.cell_type == "Izhikevich" else 1.0
        return _Izhikevich(sample, p, [v, initial["u"]], _izhikevich(p, per_na * current))
    if sample.cell_type == "HH_cond_exp":
        return _HodgkinHuxley(sample, p, [v, *_settled_gates(v - p["v_offset"])], _hodgkin_huxley(p, current))
    if sample.loses_refractory_input:
        return _Frozen(sample, p, [v], _leaky(p, current))
    if sample.cell_type.startswith("EIF"):
        return _AdaptiveExponential(sample, p, [v, initial["w"]], _adaptive(p, current))
    return _Cell(sample, p, [v], _leaky(p, current))


def _leaky(p: Mapping[str, float], current: float) -> Slopes:
    rest, tau, cm = p["v_rest"], p["tau_m"], p["cm"]

    def slopes(y: State, synaptic: float) -> State:
        return [(rest - y[0]) / tau + (current + synaptic) / cm]

    return slopes


def _adaptive(p: Mapping[str, float], current: float) -> Slopes:
    rest, tau, cm, sharp = p["v_rest"], p["tau_m"], p["cm"], p["delta_T"]

    def slopes(y: State, synaptic: float) -> State:
        v, w = y[0], y[1]
        upstroke = sharp * exp(min((v - p["v_thresh"]) / sharp, 20.0))
        rise = (rest - v + upstroke) / tau + (current + synaptic - w) / cm
        return [rise, (p["a"] * 1e-3 * (v - rest) - w) / p["tau_w"]]

    return slopes


def _izhikevich(p: Mapping[str, float], current: float) -> Slopes:
    """Return the slopes under a current per capacitance: PyNN's nA times 1000, sPyNNaker's nA unscaled."""

    def slopes(y: State, synaptic: float) -> State:
        v, u = y[0], y[1]
        return [0.04 * v * v + 5 * v + 140 - u + current + synaptic, p["a"] * (p["b"] * v - u)]

    return slopes


def _hodgkin_huxley(p: Mapping[str, float], current: float) -> Slopes:
    def slopes(y: State, synaptic: float) -> State:
        v, m, h, n = y[:4]
        ionic = p["gbar_Na"] * m**3 * h * (p["e_rev_Na"] - v) + p["gbar_K"] * n**4 * (p["e_rev_K"] - v)
        leak = p["g_leak"] * (p["e_rev_leak"] - v)
        gates = zip((m, h, n), _rates(v - p["v_offset"]), strict=True)
        return [(ionic + leak + current + synaptic) / p["cm"], *(o * (1 - g) - c * g for g, (o, c) in gates)]

    return slopes


def _rates(v: float) -> tuple[tuple[float, float], ...]:
    """Return the rates (per ms) at which the gates m, h and n open and close, v from ``v_offset``."""
    m = 0.32 * (13 - v) / (exp((13 - v) / 4) - 1), 0.28 * (v - 40) / (exp((v - 40) / 5) - 1)
    h = 0.128 * exp((17 - v) / 18), 4 / (1 + exp((40 - v) / 5))
    n = 0.032 * (15 - v) / (exp((15 - v) / 5) - 1), 0.5 * exp((10 - v) / 40)
    return m, h, n


def _settled_gates(v: float) -> list[float]:
    return [opening / (opening + closing) for opening, closing in _rates(v)]
