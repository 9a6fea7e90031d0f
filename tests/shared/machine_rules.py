"""Plain arithmetic of the machine's STDP, and cells that fire when they are told to."""

from collections.abc import Callable
from math import exp

import numpy as np

from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import SynapticEvents

MS = 1_000_000
ADDITIVE, MULTIPLICATIVE = "AdditiveWeightDependence", "MultiplicativeWeightDependence"
SHIFT, RAW = 2, 2**15 >> 2
PAIRS = {"tau_plus": 16.7, "tau_minus": 33.7, "A_plus": 0.05, "A_minus": 0.06, "w_min": 0.1, "w_max": 2.0}
OBEDIENT = {"tau_refrac": 0.0, "tau_syn_E": 0.1, "tau_m": 1.0, "v_thresh": -30.0}
"""A cell that fires in each tick in which a strong input arrives, and only then."""


def named(weight: str, timing: str = "SpikePairRule") -> dict[str, str]:
    return {"timing_dependence": timing, "weight_dependence": weight}


def fire(brain: Brain, ticks: list[int]) -> None:
    n, neuron = len(ticks), brain.network.size - 1
    if n:
        brain._do_inject(SynapticEvents(np.full(n, neuron), np.array(ticks, float), np.full(n, 2000.0)))


def floor_mul(a: int, b: int) -> int:
    return a * b // 2**15


def table(tau: float, shift: int = 0) -> Callable[[int], int]:
    """Return the decay of a table with an entry for ``2**shift`` ticks, s4.11; 0 for a time below 0."""
    return lambda ticks: int(2048 * exp(-(ticks >> shift << shift) / tau)) if ticks >= 0 else 0


def bits(rule: dict[str, float], scale: float, *names: str) -> list[int]:
    """Return parameters as s16.15."""
    return [round(rule[name] * scale * 2**15) for name in names]
