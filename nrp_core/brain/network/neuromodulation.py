"""Neuromodulation: rewards and punishments that decide how much STDP changes the weights onto a population.

The model of Izhikevich (2007, Cereb Cortex 17:2443) as sPyNNaker has it. STDP changes the eligibility of a
synapse instead of its weight; the weight follows the product of eligibility and dopamine.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import ClassVar, Final

from nrp_core.brain.network.settings import SMALLEST, Settings
from nrp_core.errors import NetworkError

MODULATORY: Final = ("reward", "punishment")
"""The receptors of synapses that raise and lower the dopamine of their target."""


@dataclass(frozen=True, slots=True)
class Neuromodulation(Settings):
    """How rewards and punishments act, by the names of sPyNNaker.

    The weight of a synapse that rewards or punishes is the change of dopamine by a spike; it has no unit.

    Args:
        tau_c: time constant of the eligibility of a synapse, ms.
        tau_d: time constant of the dopamine of a target cell, ms.
        w_min, w_max: limits of the weights that rewards change, nA or uS.

    Raises:
        NetworkError: a value is impossible.
    """

    KIND: ClassVar[str] = "neuromodulation"

    tau_c: float = 1000.0
    tau_d: float = 200.0
    w_min: float = 0.0
    w_max: float = 1.0

    def __post_init__(self) -> None:
        for name in ("tau_c", "tau_d"):
            self._require(name, SMALLEST, inf, "more than 0, and finite")
        for name in ("w_min", "w_max"):
            self._require(name, 0.0, inf, "0 or more, and finite")
        if self.w_min > self.w_max:
            raise NetworkError(
                f"neuromodulation: w_min is {self.w_min:g}; it must be at most w_max, {self.w_max:g}"
            )
