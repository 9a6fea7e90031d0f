"""The parameters of Tsodyks-Markram synapses."""

from __future__ import annotations

from typing import Final

import numpy as np
from nrp_core.brain import TSODYKS_MARKRAM, FloatArray, Network, Projection

_APART: Final = 1.0 + 1e-6
"""PyNN's models divide by the difference of the time constants of recovery and decay."""


def short_term(network: Network, projection: Projection) -> dict[str, FloatArray]:
    """Return the parameters of synapses for the simulators; empty for other kinds."""
    if projection.synapse_type != TSODYKS_MARKRAM:
        return {}
    given = dict(projection.synapse_parameters)
    equal = np.isclose(given["tau_rec"], decay_ms(network, projection), rtol=1e-7)
    return given | {"tau_rec": np.where(equal, given["tau_rec"] * _APART, given["tau_rec"])}


def decay_ms(network: Network, projection: Projection) -> FloatArray:
    """Return the time constant with which each synapse's effect on its cell decays, 0 for a jump."""
    decay = "tau_syn_E" if projection.receptor == "excitatory" else "tau_syn_I"
    given = network.populations[projection.post].parameters.get(decay)
    return np.zeros(projection.size) if given is None else given[projection.post_index]
