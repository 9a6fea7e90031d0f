"""Pools of motoneurons with the size principle, as parameters of cells of PyNN."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class MotoneuronPool:
    """A pool of motor units with the size principle, for ``IF_curr_exp`` cells of PyNN.

    The rheobases of units grow exponentially from the smallest to the largest, as do their twitches (A. J.
    Fuglevand et al., J. Neurophysiol. 70:2470, 1993). All cells have one time constant; a large one has a
    large capacity, so that a common input recruits small ones first and releases them last.
    ::

        pool = MotoneuronPool(100)
        biceps = sim.Population(100, sim.IF_curr_exp(**pool.parameters()), label="biceps")

    Args:
        size: the number of units.
        rheobase: that of the smallest unit, nA.
        recruitment: the rheobase of the largest unit in units of that.
        twitch: the twitch of the largest unit in units of that of the smallest.
        tau_m, tau_refrac, tau_syn: time constants, ms.
        threshold: between resting and threshold potential, mV.
    """

    size: int
    rheobase: float = 0.3
    recruitment: float = 10.0
    twitch: float = 30.0
    tau_m: float = 10.0
    tau_refrac: float = 5.0
    tau_syn: float = 2.0
    threshold: float = 15.0

    @property
    def rheobases(self) -> FloatArray:
        """The currents above which units fire, nA, shape ``(size,)``."""
        return self.rheobase * self.recruitment**self._ranks

    @property
    def twitches(self) -> FloatArray:
        """The shares of units in the force of the pool, shape ``(size,)``."""
        sizes = self.twitch**self._ranks
        return np.asarray(sizes / sizes.sum())

    @property
    def _ranks(self) -> FloatArray:
        return np.linspace(0.0, 1.0, self.size)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters of ``IF_curr_exp``: capacities (nF) by unit, time constants, potentials."""
        return {
            "cm": (self.rheobases * self.tau_m / self.threshold).tolist(),
            "tau_m": self.tau_m,
            "tau_refrac": self.tau_refrac,
            "tau_syn_E": self.tau_syn,
            "tau_syn_I": self.tau_syn,
            "v_rest": -65.0,
            "v_reset": -65.0,
            "v_thresh": -65.0 + self.threshold,
        }

    def excitation(self, rates: Any, saturation: float = 40.0) -> float:
        """Return the control of a muscle from the rates of its units (Hz), weighted by their twitches."""
        return float(np.clip(np.asarray(rates) / saturation, 0.0, 1.0) @ self.twitches)
