"""Structural plasticity and neuromodulation of the synapses of a network.

Synapses of a projection form and vanish while the network runs, in the model of Bamford, Murray & Willshaw
(2010, Neurocomputing 74:517) as sPyNNaker has it. A target cell has a number of places for synapses. Attempts
occur at a fixed rate: each takes a target cell and one of its places at random. A synapse at the place may
vanish; at an empty place, one from a chosen source cell may form.

Rewards and punishments decide how much STDP changes the weights onto a population, in the model of Izhikevich
(2007, Cereb Cortex 17:2443) as sPyNNaker has it. STDP changes the eligibility of a synapse instead of its
weight; the weight follows the product of eligibility and dopamine.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from sys import float_info
from typing import Any, ClassVar, Final, Literal, get_args

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.frozen_values import SMALLEST, Settings, copy_mappings

MODULATORY: Final = ("reward", "punishment")
"""The receptors of synapses that raise and lower the dopamine of their target."""


@dataclass(frozen=True, slots=True)
class Neuromodulation(Settings):
    """How rewards and punishments act, by the names of sPyNNaker.

    The weight of a synapse that rewards or punishes is the change of dopamine by a spike; it has no unit.
    With the weight ``1 / tau_d``, and without limits of the eligibility, ``shared`` dopamine is that of
    NEST's ``stdp_dopamine_synapse``.

    Args:
        tau_c: time constant of the eligibility of a synapse, ms.
        tau_d: time constant of the dopamine of a target cell, ms.
        w_min, w_max: limits of the weights that rewards change, nA or uS.
        baseline: dopamine at which weights stay: they change by the product of eligibility and
            ``dopamine - baseline``.
        shared: whether all cells of the target have one dopamine, the mean of what each would have. It acts
            on their synapses at once; that of a single cell acts after the dendritic part of the delay.
        eligibility_limits: whether the eligibility stays within ``w_min`` and ``w_max`` of the STDP rule.

    Raises:
        NetworkError: a value is impossible.
    """

    KIND: ClassVar[str] = "neuromodulation"

    tau_c: float = 1000.0
    tau_d: float = 200.0
    w_min: float = 0.0
    w_max: float = 1.0
    baseline: float = 0.0
    shared: bool = False
    eligibility_limits: bool = True

    def __post_init__(self) -> None:
        self._require("baseline", -float_info.max, inf, "a finite number")
        for name in ("shared", "eligibility_limits"):
            if getattr(self, name) not in (True, False):
                raise NetworkError(f"neuromodulation: {name} is {getattr(self, name)!r}; it must be a bool")
            object.__setattr__(self, name, bool(getattr(self, name)))
        for name in ("tau_c", "tau_d"):
            self._require(name, SMALLEST, inf, "more than 0, and finite")
        for name in ("w_min", "w_max"):
            self._require(name, 0.0, inf, "0 or more, and finite")
        if self.w_min > self.w_max:
            raise NetworkError(
                f"neuromodulation: w_min is {self.w_min:g}; it must be at most w_max, {self.w_max:g}"
            )

    @property
    def is_of_machine(self) -> bool:
        """Whether SpiNNaker supports it: parameters that its software lacks have its implied values."""
        return not (self.baseline or self.shared) and self.eligibility_limits

    def data(self) -> dict[str, Any]:
        """Return it as plain data; parameters that SpiNNaker lacks only if they are given."""
        found = Settings.data(self)  # super() does not know a class with slots
        implied = {"baseline": 0.0, "shared": False, "eligibility_limits": True}
        return {name: value for name, value in found.items() if implied.get(name, ...) != value}


Partner = Literal["RandomSelection", "LastNeuronSelection"]
PARTNERS: Final[tuple[str, ...]] = get_args(Partner)

_PROBABILITIES: Final = ("p_form_forward", "p_form_lateral", "prob_elim_depressed", "prob_elim_potentiated")
_POSITIVE: Final = ("f_rew", "sigma_form_forward", "sigma_form_lateral")
_NOT_NEGATIVE: Final = ("initial_weight", "threshold", "initial_delay_low", "initial_delay_high")
_COUNTS: Final = ("s_max", "spike_buffer_size", "grid_x", "grid_y")
_LARGEST_SEED: Final = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Rewiring(Settings):
    """How synapses form and vanish, by the names of sPyNNaker.

    Args:
        partner: how the source of a new synapse is chosen: ``RandomSelection`` among all cells of all such
            projections, ``LastNeuronSelection`` among those that fired in the previous time step.
        spike_buffer_size: the number of spikes in a step that ``LastNeuronSelection`` remembers.
        grid_x, grid_y: the size of the periodic grid on which both populations lie, cell after cell.
        p_form_forward, sigma_form_forward: the probability that a synapse forms is
            ``p exp(-d**2 / (2 sigma**2))`` for the distance d on the grid.
        p_form_lateral, sigma_form_lateral: the same within one population.
        threshold: weight (nA or uS) below which a synapse is depressed.
        prob_elim_depressed, prob_elim_potentiated: the probability with which a synapse at the chosen place
            vanishes, below the threshold and from there on.
        f_rew: attempts a second in the target population.
        initial_weight: weight of a new synapse, nA or uS.
        initial_delay_low, initial_delay_high: its delay is drawn from this range, ms.
        s_max: number of places of each target cell.
        with_replacement: whether a cell may have several synapses from the same source.
        seed: seed of the random numbers, or None for those of the run.
        stream: label of the first population whose seeds are drawn from the same stream, or nothing if the
            population has a stream of its own.
        parameters: parameters of the law of a new synapse, PyNN names and units.

    Raises:
        NetworkError: a value is impossible.
    """

    KIND: ClassVar[str] = "rewiring"

    partner: str = "RandomSelection"
    spike_buffer_size: int = 64
    grid_x: int = 16
    grid_y: int = 16
    p_form_forward: float = 0.16
    sigma_form_forward: float = 2.5
    p_form_lateral: float = 1.0
    sigma_form_lateral: float = 1.0
    threshold: float = 0.0
    prob_elim_depressed: float = 0.0245
    prob_elim_potentiated: float = 1.36e-4
    f_rew: float = 1e4
    initial_weight: float = 0.0
    initial_delay_low: float = 1.0
    initial_delay_high: float = 1.0
    s_max: int = 32
    with_replacement: bool = True
    seed: int | None = None
    stream: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.partner not in PARTNERS:
            raise NetworkError(f"rewiring: partner '{self.partner}'{did_you_mean(self.partner, PARTNERS)}")
        for name in _PROBABILITIES:
            self._require(name, 0.0, 1.0, "a number from 0 to 1")
        for name in _POSITIVE:
            self._require(name, SMALLEST, inf, "more than 0, and finite")
        for name in _NOT_NEGATIVE:
            self._require(name, 0.0, inf, "0 or more, and finite")
        for name in _COUNTS:
            self._require(name, 1, inf, "a whole number from 1 on", whole=True)
        if self.seed is not None:
            self._require("seed", 0, _LARGEST_SEED, f"a whole number from 0 to {_LARGEST_SEED}", whole=True)
        object.__setattr__(self, "with_replacement", bool(self.with_replacement))
        copy_mappings(self, self.KIND, "parameters")
        if self.initial_delay_low > self.initial_delay_high:
            raise NetworkError(
                f"rewiring: initial_delay goes from {self.initial_delay_low:g} ms to "
                f"{self.initial_delay_high:g} ms; the first must be the smaller one"
            )

    def data(self) -> dict[str, Any]:
        """Return it as plain data; without a stream as before there were any."""
        found = Settings.data(self)  # super() does not know a class with slots
        return found if self.stream else {name: value for name, value in found.items() if name != "stream"}
