"""Spike-timing-dependent plasticity by pairs of spikes, additive or multiplicative."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.parameters import FRACTION, NUMBER, POSITIVE, Parameter
from nrp_core.brain.network.synapses.law import RulePart, SynapseLaw

STDP: Final = "stdp"

_LIMITS: Final = ("w_min", "w_max")

LAW: Final = SynapseLaw(
    STDP,
    pynn="STDPMechanism",
    summary="Plasticity by spike pairs, additive or multiplicative.",
    parameters={
        "A_plus": Parameter(0.01),
        "A_minus": Parameter(0.01),
        "tau_plus": Parameter(20.0, "ms", POSITIVE),
        "tau_minus": Parameter(20.0, "ms", POSITIVE),
        "w_min": Parameter(0.0, "uS, nA or mV", NUMBER),
        "w_max": Parameter(1.0, "uS, nA or mV", NUMBER),
        "dendritic_delay_fraction": Parameter(1.0, limit=FRACTION),
    },
    parts={
        "timing_dependence": {
            "SpikePairRule": RulePart(
                "Weight changes by the time between pairs of spikes; time constants in ms.",
                ("tau_plus", "tau_minus", "A_plus", "A_minus"),
                stands_for=("Vogels2011Rule",),
            ),
        },
        "weight_dependence": {
            "AdditiveWeightDependence": RulePart(
                "Weight changes that do not depend on the weight, within ``w_min`` and ``w_max``.",
                _LIMITS,
                stands_for=("AdditivePotentiationMultiplicativeDepression",),
            ),
            "MultiplicativeWeightDependence": RulePart(
                "Weight changes in proportion to the distance from ``w_min`` or ``w_max``.",
                _LIMITS,
                stands_for=("GutigWeightDependence",),
            ),
        },
    },
)
