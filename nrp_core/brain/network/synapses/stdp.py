"""Spike-timing-dependent plasticity, composed of a rule for times and one for weights."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.parameters import FRACTION, NOT_NEGATIVE, NUMBER, POSITIVE, Parameter
from nrp_core.brain.network.synapses.law import RulePart, SynapseLaw

STDP: Final = "stdp"

_LIMITS: Final = ("w_min", "w_max")
_PAIRS: Final = ("tau_plus", "tau_minus", "A_plus", "A_minus")
_ADDITIVE: Final = {"weight_dependence": "AdditiveWeightDependence"}

LAW: Final = SynapseLaw(
    STDP,
    pynn="STDPMechanism",
    summary="Plasticity by the times of the spikes of both sides.",
    parameters={
        "A_plus": Parameter(0.01),
        "A_minus": Parameter(0.01),
        "tau_plus": Parameter(20.0, "ms", POSITIVE),
        "tau_minus": Parameter(20.0, "ms", POSITIVE),
        "A3_plus": Parameter(0.01),
        "A3_minus": Parameter(0.0),
        "tau_x": Parameter(100.0, "ms", POSITIVE),
        "tau_y": Parameter(100.0, "ms", POSITIVE),
        "eta": Parameter(1e-10, "uS, nA or mV"),
        "rho": Parameter(3.0, "Hz", NOT_NEGATIVE),
        "tau": Parameter(20.0, "ms", POSITIVE),
        "w_min": Parameter(0.0, "uS, nA or mV", NUMBER),
        "w_max": Parameter(1.0, "uS, nA or mV", NUMBER),
        "mu_plus": Parameter(0.5, limit=NOT_NEGATIVE),
        "mu_minus": Parameter(0.5, limit=NOT_NEGATIVE),
        "dendritic_delay_fraction": Parameter(1.0, limit=FRACTION),
    },
    parts={
        "timing_dependence": {
            "SpikePairRule": RulePart(
                "Weight changes by the time between pairs of spikes; time constants in ms.", _PAIRS
            ),
            "Vogels2011Rule": RulePart(
                "Inhibitory plasticity (Vogels et al. 2011, Science 334:1569): each pair of spikes, in any "
                "order, strengthens by ``eta`` within ``tau`` (ms); each spike of the source weakens, which "
                "keeps the target near ``rho`` (Hz).",
                ("tau", "eta", "rho"),
                requires=_ADDITIVE,
            ),
            "PfisterSpikeTripletRule": RulePart(
                "Weight changes by pairs and triplets of spikes (Pfister & Gerstner 2006, J Neurosci "
                "26:9673); ``tau_x`` and ``tau_y`` (ms) of earlier spikes of the source and of the target.",
                (*_PAIRS, "tau_x", "tau_y", "A3_plus", "A3_minus"),
                requires=_ADDITIVE,
            ),
        },
        "weight_dependence": {
            "AdditiveWeightDependence": RulePart(
                "Weight changes that do not depend on the weight, within ``w_min`` and ``w_max``.",
                _LIMITS,
                implied={"mu_plus": 0.0, "mu_minus": 0.0},
            ),
            "MultiplicativeWeightDependence": RulePart(
                "Weight changes in proportion to the distance from ``w_min`` or ``w_max``.",
                _LIMITS,
                implied={"mu_plus": 1.0, "mu_minus": 1.0},
            ),
            "AdditivePotentiationMultiplicativeDepression": RulePart(
                "Increases that do not depend on the weight, decreases in proportion to the distance "
                "from ``w_min``.",
                _LIMITS,
                implied={"mu_plus": 0.0, "mu_minus": 1.0},
            ),
            "GutigWeightDependence": RulePart(
                "Weight changes by powers ``mu_plus`` and ``mu_minus`` of the distance from ``w_max`` and "
                "``w_min``, as a share of ``w_max`` (Gütig et al. 2003, J Neurosci 23:3697).",
                (*_LIMITS, "mu_plus", "mu_minus"),
            ),
        },
    },
    state=dict.fromkeys(("pre_trace", "post_trace", "pre_slow", "post_slow"), Parameter(0.0)),
    plastic=True,
)
