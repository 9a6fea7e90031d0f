"""Helpers for the tests of brains: sample cells with a known response, networks, and how they are run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil
from typing import Any

import numpy as np

from nrp_conformance.base import SimulatorTests, skip_undeclared
from nrp_core import brains
from nrp_core.brain import Brain, BrainBackend, BrainCapabilities, SpikeRecorder, SpikeRecorderPort
from nrp_core.clock import from_milliseconds, milliseconds
from nrp_core.network.cells import CELLS
from nrp_core.network.currents import InjectedCurrent
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.synapses import STATIC
from nrp_core.world import FloatArray

_LEAKY = {  # the reset is below the resting potential, so that tests can distinguish them
    "v_rest": -65.0, "v_reset": -68.0, "v_thresh": -50.0, "tau_m": 10.0, "cm": 0.25, "tau_refrac": 10.0,
}  # fmt: skip
_CURRENTS = _LEAKY | {"tau_syn_E": 2.0, "tau_syn_I": 3.0}
_ADAPTIVE = {"tau_refrac": 10.0, "tau_syn_E": 2.0, "v_reset": -66.0}
_CONDUCTANCES = _CURRENTS | {"e_rev_E": 0.0, "e_rev_I": -75.0}
Part = Population | Projection
Pairs = Sequence[tuple[int, int]]
Numbers = float | Sequence[float]
EXACT_MS = 1e-3
"""The allowed time error of a brain without a time grid: the accuracy of the reference."""
Train = list[tuple[int, float]]


@dataclass(frozen=True, slots=True)
class Sample:
    """A cell that rests without input.

    Args:
        cell_type: PyNN's name.
        parameters: the parameters that differ from PyNN's defaults.
        current_na: a current at which it fires regularly, nA.
        strong: a weight with which one excitatory spike makes it fire once.
        weak: a weight whose potential stays far below the threshold.
        rest_mv: its resting potential, if not ``v_rest`` or PyNN's initial value.
        loses_refractory_input: whether synapses freeze in the refractory period, and arriving spikes are
            lost. Else the membrane alone is clamped.
    """

    cell_type: str
    parameters: Mapping[str, float] = field(default_factory=dict, hash=False)
    current_na: float = 0.8
    strong: float = 5.0
    weak: float = 0.1
    rest_mv: float | None = None
    loses_refractory_input: bool = False

    @property
    def all_parameters(self) -> dict[str, float]:
        """All parameters, by PyNN's names."""
        defaults = {name: known.default for name, known in CELLS[self.cell_type].parameters.items()}
        return {**defaults, **self.parameters}

    @property
    def initial_values(self) -> dict[str, float]:
        """The resting potential, mV."""
        initial = {name: known.default for name, known in CELLS[self.cell_type].state.items()}
        rest_mv = self.parameters.get("v_rest", self.rest_mv)
        if rest_mv is not None:
            initial["v"] = rest_mv
        return {name: value for name, value in initial.items() if name in ("v", "u", "w")}

    @property
    def inhibitory_sign(self) -> int:
        """The sign of a weight on the inhibitory receptor."""
        return 1 if "_cond_" in self.cell_type else -1


SAMPLES = {
    sample.cell_type: sample
    for sample in (  # in the order in which a test prefers them
        Sample("IF_cond_alpha", _CONDUCTANCES, strong=0.05, weak=0.001),
        Sample("IF_cond_exp", _CONDUCTANCES, strong=0.1, weak=0.002),
        Sample("IF_curr_exp", _CURRENTS),
        Sample("IF_curr_alpha", _CURRENTS, strong=3.0, weak=0.05),
        Sample("IF_curr_delta", _LEAKY, strong=20.0, weak=2.0),
        Sample("IF_curr_exp_frozen", _CURRENTS, strong=300.0, weak=4.0, loses_refractory_input=True),
        Sample("EIF_cond_alpha_isfa_ista", _ADAPTIVE, 1.0, 0.1, 0.001),
        Sample("EIF_cond_exp_isfa_ista", _ADAPTIVE, 1.0, 0.2, 0.002),
        Sample("Izhikevich", {"d": 8.0}, 0.01, 60.0, 1.0),
        Sample("IZK_curr_exp", {"d": 8.0, "tau_syn_E": 2.0, "tau_syn_I": 3.0}, 10.0, 30.0, 1.0),
        Sample("IZK_cond_exp", {"d": 8.0, "tau_syn_E": 2.0, "tau_syn_I": 3.0}, 10.0, 0.4, 0.01),
        Sample("HH_cond_exp", {"tau_syn_E": 2.0}, 0.5, 0.1, 0.001, rest_mv=-64.76462926),
    )
}


def network(*parts: Part) -> Network:
    """Return a network of populations and projections."""
    populations = {part.label: part for part in parts if isinstance(part, Population)}
    return Network(populations, tuple(part for part in parts if isinstance(part, Projection)))


def cells(sample: Sample, label: str, size: int = 1, **parameters: Any) -> Population:
    """Return sample cells; a parameter is one number for all, or one for each."""
    values = {**sample.all_parameters, **parameters}
    return Population(label, size, sample.cell_type, _each(values, size), _each(sample.initial_values, size))


def spikes(label: str, *trains: Sequence[float]) -> Population:
    """Return cells that emit given spikes (ms)."""
    arrays = tuple(np.asarray(train, dtype=float) for train in trains)
    return Population(label, len(trains), "SpikeSourceArray", {}, {}, arrays)


def poisson(label: str, size: int, rate: float) -> Population:
    """Return cells that emit Poisson trains at a constant rate, Hz."""
    values = {"rate": rate, "start": 0.0, "duration": 1e10}
    return Population(label, size, "SpikeSourcePoisson", _each(values, size))


def connect(
    pre: str, post: str, weight: Numbers, delay: Numbers = 1.0, *,
    pairs: Pairs = ((0, 0),), receptor: str = "excitatory", kind: str = STATIC,
    rule: Mapping[str, str] | None = None, **parameters: Numbers,
) -> Projection:  # fmt: skip
    """Return synapses between pairs of cells; a number is the same for all, or one for each; delays in ms."""
    pre_index, post_index = np.array(pairs, np.int32).T
    n = len(pre_index)
    return Projection(
        f"{pre} to {post}, {receptor}", pre, post, receptor, pre_index, post_index,
        _broadcast(weight, n), _broadcast(delay, n),
        kind, _each(parameters, n), dict(rule or {}),
    )  # fmt: skip


def _each(values: Mapping[str, Any], size: int) -> dict[str, Any]:
    return {name: _broadcast(value, size) for name, value in values.items()}


def _broadcast(value: Numbers, size: int) -> FloatArray:
    return np.broadcast_to(np.asarray(value, float), size).copy()


def truncated_ms(step_ms: float, from_ms: float) -> float:
    """Return a multiple of a step, ms, whose quotient by the step is a little below the whole number.

    Who truncates that quotient gets a step too few. Without such a multiple the result is ``from_ms``.
    """
    first = ceil(from_ms / step_ms)
    multiples = ((n, round(n * step_ms, 6)) for n in range(first, first + 1000))
    return next((t_ms for n, t_ms in multiples if int(t_ms / step_ms) < n), from_ms)


class BrainKit(SimulatorTests[BrainBackend, BrainCapabilities]):
    """Opens the brain under test."""

    @classmethod
    def make_backend(cls) -> BrainBackend:
        return brains().load(cls.backend_name)

    @property
    def tolerance_ms(self) -> float:
        """The allowed time shift of an event: one step of the declared grid."""
        return milliseconds(self.capabilities.resolution_ns or 0) or EXACT_MS

    def require_declared(self, *, synapses: str | None = None, state: str | None = "v") -> None:
        """Skip the test if a synapse law or a state variable is not declared, and name it."""
        missing = [f"{synapses} synapses"] if synapses and synapses not in self.capabilities.synapses else []
        if state is not None and state not in self.capabilities.state_variables:
            missing.append(f"state variable {state}")
        if missing:
            skip_undeclared(" and ".join(missing))

    def grid_ns(self, t_ms: float) -> int:
        """Return the first time at or after ``t_ms`` at which the brain can be stopped."""
        step_ns = self.capabilities.resolution_ns or 1
        return -(-from_milliseconds(t_ms) // step_ns) * step_ns

    @cached_property
    def sample(self) -> Sample:
        """A sample cell that the backend supports."""
        declared = [sample for name, sample in SAMPLES.items() if name in self.capabilities.cells]
        return declared[0] if declared else skip_undeclared("any standard cell")

    def cells(self, label: str, size: int = 1, **parameters: Any) -> Population:
        """Return cells at rest, of a type that the backend supports."""
        return cells(self.sample, label, size, **parameters)

    def open(self, *parts: Part, seed: int = 1, currents: Sequence[InjectedCurrent] = ()) -> Brain:
        """Open a network; it is closed after the test."""
        whole = replace(network(*parts), currents=tuple(currents))
        return self.opened.enter_context(self.backend.open(whole, seed=seed, options=self.chosen))

    def run(self, brain: Brain, until_ms: float) -> None:
        """Advance to the first possible time at or after ``until_ms``."""
        brain.run_until(self.grid_ns(until_ms))

    def inhibition(self, pre: str, post: str, weight: float, delay: float = 1.0) -> Projection:
        """Connect the first cells by an inhibitory synapse; ``weight`` is its absolute value."""
        signed = weight * self.sample.inhibitory_sign
        return connect(pre, post, signed, delay, receptor="inhibitory")

    def busy(self) -> tuple[Part, ...]:
        """Return a network with currents, noise, spike trains, delays and both receptors."""
        sample = self.sample
        drive = np.linspace(0.7, 1.2, 5) * sample.current_na
        back = connect(
            "b", "a", sample.strong * sample.inhibitory_sign, 2.0,
            receptor="inhibitory", pairs=[(0, 0), (1, 3), (3, 4)],
        )  # fmt: skip
        return (
            self.cells("a", 5, i_offset=drive),
            self.cells("b", 4),
            spikes("train", [3.0, 10.0, 17.25, 40.0, 61.0], [5.5, 21.0, 39.0]),
            poisson("noise", 3, 300.0),
            connect("a", "b", sample.strong, [1, 2, 3, 4, 7], pairs=[(i, i % 4) for i in range(5)]),
            connect("train", "b", sample.strong, [1, 12], pairs=[(0, 1), (1, 3)]),
            connect("noise", "a", sample.weak, 1.0, pairs=[(i, j) for i in range(3) for j in range(5)]),
            back,
        )


def record(brain: Brain, neurons: Iterable[int] | None = None, name: str = "recorder") -> SpikeRecorderPort:
    """Record spikes, by default of all neurons."""
    chosen = range(brain.network.size) if neurons is None else neurons
    port = brain.add_sink(SpikeRecorder(), list(chosen), name=name)
    assert isinstance(port, SpikeRecorderPort)
    return port


def train(port: SpikeRecorderPort, since_ms: float = float("-inf")) -> Train:
    """Return the spikes recorded after a time, as pairs of neuron and time in a canonical order."""
    found = port.spikes(since_ms)
    return sorted(zip(found.neurons.tolist(), found.times_ms.tolist(), strict=True))


def times(port: SpikeRecorderPort, neuron: int) -> list[float]:
    """Return the times (ms) of one neuron's spikes."""
    return [time for ident, time in train(port) if ident == neuron]
