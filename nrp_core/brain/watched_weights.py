"""Warnings of implausible weights that are set while a brain runs."""

from __future__ import annotations

from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.changes import projection_of
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.implausible import too_strong
from nrp_core.findings import Code, Findings

_GROWTH: Final = 2.0
"""Growth of the strongest weight after which weights are looked at again; functions set them in each step."""


class WatchedWeights:
    """Looks at the weights that are set.

    Args:
        network: the network that runs.
        warnings: receives a finding for each projection with implausible weights.
    """

    def __init__(self, network: Network, warnings: Findings) -> None:
        self._network, self._warnings = network, warnings
        self._strongest: dict[str, float] = {}
        self._found: set[str] = set()
        self._inhibiting: set[str] = set()

    def look(self, label: str, weights: FloatArray) -> None:
        """Warn of weights of a projection, in PyNN's units, the first time that they are implausible."""
        self._look_at_sign(label, weights)
        strongest = float(np.abs(weights).max(initial=0.0))
        if label in self._found or strongest <= _GROWTH * self._strongest.get(label, 0.0):
            return
        self._strongest[label] = strongest
        projection = projection_of(self._network, label)
        wrong = too_strong(strongest, self._network.populations[projection.post])
        if wrong:
            self._found.add(label)
            message = f"a weight of the projection '{label}' is set to {wrong}"
            self._warnings.add(Code.NRP297, message, subject=label)

    def _look_at_sign(self, label: str, weights: FloatArray) -> None:
        """Warn of weights that turn the excitation of a projection into inhibition."""
        lowest = float(weights.min(initial=0.0))
        if lowest < 0 and label not in self._inhibiting:
            self._inhibiting.add(label)
            projection = projection_of(self._network, label)
            if projection.is_excitatory and not (np.asarray(projection.weight) < 0).any():
                message = f"a weight of the excitatory projection '{label}' is set to {lowest:g}: it inhibits"
                self._warnings.add(Code.NRP297, message, subject=label)
