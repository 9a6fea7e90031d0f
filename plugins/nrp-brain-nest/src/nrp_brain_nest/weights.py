"""Weights in NEST's units, in which the sign of a weight selects the receptor."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from nrp_core.brain import RECEPTORS, FloatArray, IntArray, Network
from nrp_core.errors import CapabilityError

from nrp_brain_nest.cell_types import CELL_TYPES, MILLI


class Weights:
    """Converts weights onto the cells of a network."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._factors = np.ones((len(RECEPTORS), network.size))
        self._sign_is_receptor = np.zeros(network.size, bool)
        for label, population in network.populations.items():
            if population.is_source:
                continue
            ids, drive = network.ids_of(label), CELL_TYPES[population.cell_type].drive
            if drive == "jump":
                continue
            self._factors[:, ids] = MILLI
            if drive == "conductance":
                self._factors[RECEPTORS.index("inhibitory"), ids] = -MILLI
            taus = population.parameters["tau_syn_E"], population.parameters["tau_syn_I"]
            self._sign_is_receptor[ids] = drive == "conductance" or taus[0] != taus[1]

    def onto(self, neurons: IntArray, weights: FloatArray, receptor: str) -> FloatArray:
        """Return NEST's weights of synapses on neurons (global ids).

        Raises:
            CapabilityError: NEST would use the other receptor.
        """
        values: FloatArray = weights * self._factors[RECEPTORS.index(receptor), neurons]
        wrong = values < 0 if receptor == "excitatory" else values > 0
        wrong &= self._sign_is_receptor[neurons]
        if wrong.any():
            first = int(np.flatnonzero(wrong)[0])
            label, cell = self._network.label_of(int(neurons[first]))
            raise CapabilityError(
                f"NEST selects receptors by the sign of the weight, so it has no {receptor} synapse with "
                f"weight {weights[first]:g} on cell {cell} of population '{label}'"
            )
        return values

    def of(self, neurons: IntArray, values: FloatArray, receptor: str) -> FloatArray:
        """Return the weights in PyNN's units, the inverse of :meth:`onto`."""
        weights: FloatArray = values / self._factors[RECEPTORS.index(receptor), neurons]
        return weights

    def check_receptors(self, label: str, parameters: Mapping[str, FloatArray]) -> None:
        """Check that changed parameters of a population keep the meaning of signs.

        Raises:
            CapabilityError: the receptors become different, so that existing weights may be on the wrong one.
        """
        ids = self._network.ids_of(label)
        if CELL_TYPES[self._network.populations[label].cell_type].drive == "current":
            differ = parameters["tau_syn_E"] != parameters["tau_syn_I"]
            if (differ != self._sign_is_receptor[ids]).any():
                raise CapabilityError(
                    f"population '{label}': NEST selects receptors by the sign of the weight, so "
                    "tau_syn_E and tau_syn_I cannot become different, or equal, while it runs"
                )
